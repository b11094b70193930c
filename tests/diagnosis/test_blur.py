"""An effect may gain by an error in the form of another one only as far as its torque has the form
of such an error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from flexhex.diagnosis.selection.blur import Blur
from flexhex.diagnosis.selection.changed import ChangedParameter
from flexhex.diagnosis.selection.choose import effect_scores
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.form import space_of_errors
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.search import Search
from tests.diagnosis.test_selection import RMS, Array, bench_of


def test_errors_of_friction_turn_over_with_it(tmp_path: Path) -> None:
    """Friction times a factor of the angle or of the rate, and friction that comes late, are errors
    of its form; a torque of the angle alone hardly is, as the axis passes there both ways."""
    rows = Rows.of(bench_of(tmp_path, None).model)
    angle, rate = rows.angles[:, 0], rows.rates[:, 0]
    dry = np.tanh(rate / 0.05)
    space = space_of_errors(rows, 0, dry)
    # no direction counts twice, and that of the torque itself counts whole
    basis = solve_triangular(space.factor, (space.columns / space.sizes).T, lower=True).T
    assert np.linalg.eigvalsh(basis.T @ basis).max() < 1 + 1e-9
    assert space.square(dry) == pytest.approx(dry @ dry, rel=1e-6)

    def share(torque: Array) -> float:
        return space.square(torque) / float(torque @ torque)

    late = np.concatenate([np.gradient(dry[run]) for run in rows.runs])
    for error in (dry * np.sin(9.0 * angle), dry * np.exp(-((rate / 0.5) ** 2)), late):
        assert share(error) > 0.98
    for other in (np.sin(40.0 * angle), np.sin(80.0 * angle)):
        assert share(other) < 0.4


def test_small_harmonic_of_a_wave_is_found_beside_friction(tmp_path: Path) -> None:
    """It gains less than a tenth of friction would, but is nothing that friction may leave."""

    def torque(q: Array, v: Array, a: Array) -> Array:
        wave = 0.1 * np.sin(17.0 * q) + 0.02 * np.cos(34.0 * q)
        return np.asarray(RMS * (0.4 * np.tanh(v / 0.01) + wave))

    side = found(bench_of(tmp_path, torque), (), lambda text: None).side
    waves = next(effect for effect in side.named if effect.id == "cogging_harmonic")
    orders = [v.value for name, v in waves.parameters.items() if name.startswith("order")]
    assert sorted(orders) == [pytest.approx(17.0, abs=0.1), pytest.approx(34.0, abs=0.2)]


@pytest.mark.parametrize(("rough", "bounded"), [(0.0, True), (0.1, False)], ids=["wave", "more"])
def test_gain_from_errors_of_form_is_bounded_by_what_is_left(
    rough: float, bounded: bool, tmp_path: Path
) -> None:
    """A small wave explains all that friction leaves. An error of friction's form would have left
    more, so the wave gained little from one. It may have where something else is left."""

    def torque(q: Array, v: Array, a: Array) -> Array:
        other = rough * np.sign(np.sin(40 * q)) * np.sin(7 * v)
        return np.asarray(RMS * (0.4 * np.tanh(v / 0.01) + 0.02 * np.cos(34.0 * q) + other))

    bench = bench_of(tmp_path, torque)
    hypotheses = Hypotheses(bench, Rows.of(bench.model))
    search = Search(hypotheses, USUAL)
    first, _ = search.next(1)
    assert first is not None
    assert first.score.hypothesis.id == "coulomb_friction"
    search.accept(first)
    plain = search.moments.without(*(error for _, error in search.terms))
    known = list(zip(search.known(), search.terms, strict=True))
    blur = Blur(search.moments, lambda: plain, hypotheses, known, USUAL)
    scores = effect_scores(search.moments, hypotheses, search.known(), USUAL, [0])
    wave = next(s for s in scores if s.hypothesis.id == "cogging_harmonic")
    most = blur.alike(wave) * blur.left[0]
    assert (blur(wave) < 0.1 * most) == bounded
    assert (blur(wave) == pytest.approx(most)) != bounded


def test_errors_of_a_changed_parameter_have_any_form(tmp_path: Path) -> None:
    """Beside a rotor that is heavier than its file says, what is left of it may be of any effect on
    its axis."""

    def torque(q: Array, v: Array, a: Array) -> Array:
        return np.asarray(0.1 * RMS * np.tanh(v / 0.01))

    bench = bench_of(tmp_path, torque)
    moments = Moments(Rows.of(bench.model))
    hypotheses = Hypotheses(bench, moments.rows)
    first = effect_scores(moments, hypotheses, (), USUAL, [0])[0]
    rotor = Score(ChangedParameter("J[1]", (0,), 0), 100.0, np.full(2, 50.0), 0.1)
    blur = Blur(moments, lambda: moments, hypotheses, [(rotor, ())], USUAL)
    assert blur.alike(first) == 1.0
    assert blur(first) == pytest.approx(blur.left[0])
