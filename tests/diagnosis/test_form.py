"""Errors of an effect's form: what they are, and that what lies within them is no other effect."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.form import ARGUMENTS, PLACES, form_errors, inexact, mean_error
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.imitated import Imitated
from flexhex.diagnosis.selection.left import Rest
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.nameless import nameless
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score, blended_term, effect_term
from flexhex.diagnosis.selection.select import select
from tests.diagnosis.test_evidence import rows_of
from tests.diagnosis.test_selection import RMS, Torque, bench_of, moved, names

Array = NDArray[np.float64]
several = pytest.mark.sample(2, of="errors of form")
FRICTION = 0.15 * RMS
WIDTH = len(ARGUMENTS) * PLACES


def worn(q: Array, v: Array, a: Array) -> Array:
    """Friction that is larger at one end of the stroke than at the other."""
    return FRICTION * np.tanh(v / 0.01) * (1 + 0.2 * np.sin(3.0 * q))


def even(q: Array, v: Array, a: Array) -> Array:
    """Dahl's friction, as the library has it: it turns within a short way."""
    z = np.zeros_like(q)
    for k in range(1, len(q)):
        sign = np.sign(q[k] - q[k - 1])
        z[k] = sign + (z[k - 1] - sign) * np.exp(-abs(q[k] - q[k - 1]) / 1e-3)
    return FRICTION * z


def rough(q: Array) -> Array:
    """Stretches with more friction, and with less."""
    return np.asarray(0.35 * np.sign(np.sin(5.0 * q)))


def narrow(q: Array) -> Array:
    """A patch at which friction is twice as large."""
    return np.asarray(np.exp(-(((q - 0.2) / 0.05) ** 2)))


def test_errors_are_smooth_factors_and_a_shift_in_time(tmp_path: Path) -> None:
    rows = Rows.of(bench_of(tmp_path, None).model)
    wave = np.sin(np.arange(rows.count) / 7.0)
    plain = Term({0: wave[:, None]}, {0: 2.0 * wave[:, None]}, np.zeros(1))
    term = form_errors(rows, plain, np.array([3.0]), 0.1)
    factors, late = term.raw[0][:, :WIDTH], term.raw[0][:, -1]
    for k in range(len(ARGUMENTS)):
        whole = factors[:, k * PLACES : (k + 1) * PLACES].sum(axis=1)
        np.testing.assert_allclose(whole, 3.0 * wave, atol=1e-9)
    inside = rows.runs[1]
    shift = np.cos(np.arange(rows.count) / 7.0)
    assert np.corrcoef(late[inside][1:-1], shift[inside][1:-1])[0, 1] > 0.999
    assert late.std() == pytest.approx((3.0 * wave).std(), rel=0.01)
    assert term.prior.tolist() == pytest.approx([*[200.0] * WIDTH, 100.0])


def test_friction_may_turn_over_within_several_angles(tmp_path: Path) -> None:
    """A share of it, up to all, within the next one of its grid that is twice as large."""
    hypotheses = Hypotheses(bench := bench_of(tmp_path, even), Rows.of(bench.model))
    friction = hypotheses.effect("coulomb_friction", 0)
    grid = sorted({shape["s_0"] for shape in friction.shapes})
    wider = hypotheses.blended(friction, {"s_0": grid[0], "v_0": 0.0})
    assert wider == {"s_0": grid[1], "v_0": 0.0}
    assert hypotheses.blended(friction, {"s_0": grid[-1], "v_0": 0.0}) is None
    drag = hypotheses.effect("quadratic_drag", 0)
    assert hypotheses.blended(drag, {}) is None
    score = Score(friction, 1.0, np.zeros(2), 0.1)
    term, gains = effect_term(hypotheses.moments, hypotheses, score), np.array([2.0])
    both = blended_term(hypotheses, score, term, gains)
    other = hypotheses.columns(friction, wider)
    for name in ("raw", "white"):
        own, wanted = getattr(both, name)[0], getattr(other, name)[0][:, 0]
        np.testing.assert_allclose(own[:, 1], 2.0 * (wanted - own[:, 0]), atol=1e-12)
    assert both.prior.tolist() == [*term.prior.tolist(), 1.0]
    calm = Score(drag, 1.0, np.zeros(2), 0.1)
    assert blended_term(hypotheses, calm, term, gains) is term


@several
def test_friction_that_varies_by_its_form_error_is_friction_alone(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, worn)
    selection = select(bench)
    assert names(selection) == ["coulomb_friction"]
    assert not nameless(selection, USUAL)
    exact = select(bench, replace(USUAL, form_error=1e-3))
    assert names(exact) != ["coulomb_friction"] or nameless(exact, USUAL)


@pytest.mark.parametrize(("varies", "form"), [(0.2, True), (0.5, False)])
def test_what_an_inexact_form_leaves_is_reported(varies: float, form: bool, tmp_path: Path) -> None:
    """More than an error of form is something beside it. `--json` can tell both, which knows no
    numbers of NumPy."""
    side = found(
        bench_of(
            tmp_path, lambda q, v, a: FRICTION * np.tanh(v / 0.01) * (1 + varies * np.sin(6 * q))
        ),
        (),
        lambda text: None,
    ).side
    assert [named.id for named in side.named] == ["coulomb_friction"]
    (rest,) = side.rests
    told = json.loads(json.dumps(rest.data()))
    assert (told["beside"], told["form"]) == (True, form)
    assert "beside what was found" in rest.sentence()
    assert ("the form of what is named there is not exact" in rest.sentence()) == form
    assert "it goes with" in rest.sentence()


def test_second_effect_that_is_no_imitation_of_the_rest_is_named(tmp_path: Path) -> None:
    """Friction leaves twice as much as there is cogging, of which a torque ripple is an imitation;
    but no function that goes with the motion makes up for the cogging."""

    def torque(q: Array, v: Array, a: Array) -> Array:
        worn = FRICTION * np.tanh(v / 0.01) * (1 + 0.5 * np.sin(6 * q))
        return np.asarray(worn + 0.02 * RMS * np.sin(60.0 * q))

    side = found(bench_of(tmp_path, torque), (), lambda text: None).side
    assert {named.id for named in side.named} == {"cogging_harmonic", "coulomb_friction"}
    assert side.rests[0].share > 2 * 0.02 / np.sqrt(2)


@several
@pytest.mark.parametrize("place", [rough, narrow])
def test_friction_with_another_one_at_places_is_friction(
    place: Callable[[Array], Array], tmp_path: Path
) -> None:
    """Something without a name says more than friction alone, but no more than friction with
    something without a name beside it."""

    def torque(q: Array, v: Array, a: Array) -> Array:
        return FRICTION * np.tanh(v / 0.01) * (1 + place(q))

    side = found(bench_of(tmp_path, torque), (), lambda text: None).side
    assert [named.id for named in side.named] == ["coulomb_friction"]
    assert [(rest.beside, rest.form) for rest in side.rests] == [(True, False)]
    low, high = side.named[0].parameters["F_c"].ci95
    assert low < FRICTION < high


def test_rest_beside_effects_is_as_large_as_what_it_gains(tmp_path: Path) -> None:
    """Where nothing repeats well: slow parts of its torque are hardly determined."""
    selection = select(bench_of(tmp_path, worn))
    ((own,), (explained,)) = selection.accepted, selection.explained
    kind, folds = selection.imitated[0].beside.hypothesis, len(own.score.without)
    for gain, there in ((0.05 * own.score.gain, True), (0.5, False)):
        beside = Score(kind, 2.0 * gain, np.full(folds, 2.0 * gain - gain / folds), 10.0)
        unsure = replace(selection, rest=(Rest(0.3, 1.0),))
        vars(unsure)["imitated"] = (Imitated(beside),)
        functions = nameless(unsure, USUAL)
        assert [left.size for left in functions.values()] == (
            [pytest.approx(np.sqrt(0.05) * explained)] if there else []
        )


@several
def test_a_second_effect_larger_than_the_error_of_the_first_is_named_too(tmp_path: Path) -> None:
    selection = select(
        bench_of(tmp_path, lambda q, v, a: worn(q, v, a) + 0.03 * RMS * np.sin(60.0 * q))
    )
    assert sorted(names(selection)) == ["cogging_harmonic", "coulomb_friction"]


@several
@pytest.mark.parametrize(("torque", "share"), [(worn, 1.0), (even, 0.5)])
def test_interval_of_a_gain_holds_the_error_of_its_form(
    torque: Torque, share: float, tmp_path: Path
) -> None:
    """The friction's mean over the motion is not its value in the middle of the stroke. Where it is
    the same everywhere the motion shows that."""
    side = found(bench_of(tmp_path, torque), (), lambda text: None).side
    ((effect,),) = [side.named]
    estimate = effect.parameters["F_c"]
    low, high = estimate.ci95
    assert low < FRICTION < high
    relative = (high - low) / 2 / estimate.value
    wanted = 1.96 * mean_error(USUAL.form_error)
    assert share < 1.0 or wanted <= relative < 1.3 * wanted
    assert relative < 1.3 * share * wanted


def test_exact_form_has_errors_as_large_as_one_coefficient_says() -> None:
    """As many as are determined say that there are none, beside one that says what was thought."""
    rng = np.random.default_rng(2)
    B, C = rng.normal(size=(400, 1)), rng.normal(size=(400, 4))
    fold = np.arange(400) // 100
    term = Term({0: C}, {0: C}, np.full(4, 1e-2))
    for size, wanted in ((0.0, np.sqrt(1 / 4)), (30.0, 1.0)):
        y = B[:, 0] + C[:, :3] @ np.full(3, size)
        moments = Moments(rows_of(y, B, np.ones(1), fold)).extended(term)
        assert inexact(moments, term) == pytest.approx(wanted, rel=1e-3)
    weak = Term({0: 1e-6 * C}, {0: 1e-6 * C}, np.full(4, 1e-2))
    moments = Moments(rows_of(y, B, np.ones(1), fold)).extended(weak)
    assert inexact(moments, weak) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("rate", [1000.0, 250.0])
def test_friction_turns_when_the_motion_does(rate: float, tmp_path: Path) -> None:
    """Its column against the sign of the true rate, smoothed alike: no shift between them."""
    bench = bench_of(tmp_path, worn, step=round(1000.0 / rate))
    columns = bench.thin("coulomb_friction", 0, {"s_0": 1e-6, "v_0": 0.0})
    apart, slopes, step = list[Array](), list[Array](), 0.2 / rate
    for block, column in zip(bench.model.blocks, columns, strict=True):
        motion, number = block.run.motion, int(block.run.trajectory)
        time = motion.t0 + motion.ts * np.arange(len(motion.theta))
        early, sign, late = (
            block.smooth(np.sign(moved(time + shift, number)[1])[:, None])[:, 0]
            for shift in (step, 0.0, -step)
        )
        apart.append(column[:, 0] - sign)
        slopes.append((early - late) / (2 * step))
    slope = np.concatenate(slopes)
    shift = -(slope @ np.concatenate(apart)) / (slope @ slope)
    assert abs(shift) < 0.15 / rate
