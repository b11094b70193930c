"""A single axis of unknown mass: dry friction that nature hides is named, and nothing else is."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.errors import UsageError
from tests.diagnosis.single import DAMPING, SECONDS, TS, J, moved, thinned, write

several = pytest.mark.sample(3, of="plain axes")

OPTIONS = Options(base="axis")
CLOCK = np.arange(round(SECONDS / TS)) * TS
DRY = {"coulomb_friction", "stribeck_friction", "second_hysteresis"}
"""What bristles with some static friction are, seen from far and from near."""


Runs = tuple[tuple[int, int], ...]


@cache
def said(friction: float, runs: Runs, judged: Runs = ((3, 1),)) -> Diagnosis:
    """The answer for runs (motion, pass); judged: on these, as they are on another motion."""
    folder = Path(mkdtemp())
    ours, theirs = (
        [write(folder / f"{s}_{k}.csv", s, k, friction) for s, k in listed]
        for listed in (runs, judged)
    )
    return diagnose(ours, theirs, options=OPTIONS)


TWICE = ((1, 1), (1, 2), (2, 1), (2, 2))


@several
@pytest.mark.parametrize("friction", [0.12, 0.02])
def test_axis_with_bristles_has_dry_friction(friction: float) -> None:
    diagnosis = said(friction, TWICE)
    assert diagnosis.verdict in ("named", "ambiguous")
    assert {effect.id for effect in diagnosis.effects} <= DRY
    assert all(set(effect.rivals) <= DRY for effect in diagnosis.effects)
    # on another motion 0.05 and 0.24 of the residual are left, the latter is the noise
    assert diagnosis.residual.held_out["after"][0] < 0.4 * diagnosis.residual.held_out["before"][0]


@several
def test_one_run_names_what_predicts_another_motion() -> None:
    one = said(0.12, TWICE[:1])
    assert one.verdict in ("named", "ambiguous")
    assert {effect.id for effect in one.effects} <= DRY
    assert one.residual.held_out["after"][0] < 0.5 * one.residual.held_out["before"][0]


@pytest.mark.parametrize("friction", [0.12, 0.0])
def test_one_run_alone_names_nothing(friction: float) -> None:
    """Nor does it where nothing is missing, and another motion is there."""
    alone = said(friction, TWICE[:1], ())
    assert "held-out run of another" in alone.notes[0]
    for one in (alone, said(0.0, TWICE[:1])):
        assert one.verdict == "cannot tell"
        assert one.effects == ()
        assert any("run it again" in note or "run each again" in note for note in one.notes)


def test_axis_without_friction_has_nothing() -> None:
    diagnosis = said(0.0, TWICE)
    assert diagnosis.verdict == "none"
    assert diagnosis.effects == ()


@several
@pytest.mark.parametrize(
    ("friction", "runs"), [(0.12, TWICE), (0.0, TWICE), (0.0, TWICE[:1])], ids=str
)
def test_parameters_of_an_axis_are_always_told(friction: float, runs: Runs) -> None:
    """Also where nothing is missing, and where one run cannot tell."""
    diagnosis = said(friction, runs, ((3, 1),) if len(runs) > 1 else ())
    assert (diagnosis.verdict == "cannot tell") == (len(runs) == 1)
    told = {one.name: one.estimate for one in diagnosis.parameters}
    for name, true in (("J[1]", J), ("d[1]", DAMPING)):
        low, high = told[name].ci95
        assert low < true < high
        assert high - low < 0.1 * true
    # a spring and a weight are hardly two on a short stroke: each by itself, or their sum
    terms = {name for one in diagnosis.parameters for name, _ in one.terms}
    assert terms == {f"{name}[1]" for name in ("J", "d", "k", "o", "g_s", "g_c")}
    assert [one["name"] for one in diagnosis.data()["parameters"]] == [*told]


@several
def test_torque_that_comes_late_is_reported_and_is_no_effect(tmp_path: Path) -> None:
    """2 ms, of the logger as far as anyone can tell."""
    paths = []
    for seed, number in TWICE:
        path = write(tmp_path / f"{seed}_{number}.csv", seed, number, 0.0)
        head, rows = path.read_text().splitlines()[:4], path.read_text().splitlines()[4:]
        cells = [row.split(",") for row in rows]
        late = [f"{a[0]},{a[1]},{b[2]}" for a, b in zip(cells[2:], cells[:-2], strict=True)]
        path.write_text("\n".join([*head, *late, ""]))
        paths.append(path)
    diagnosis = diagnose(paths, [], options=OPTIONS)
    assert diagnosis.verdict == "none"
    (note,) = [text for text in diagnosis.findings if "lags" in text]
    assert note.startswith("the torque channel lags the angles by 2 ms; treated as logger delay")
    assert not [text for text in said(0.0, TWICE).findings if "lags" in text]


@several
@pytest.mark.parametrize(("order", "step"), [(40.0, 1), (40.0, 4)])
def test_friction_and_cogging_are_no_delay(order: float, step: int, tmp_path: Path) -> None:
    """The base model alone takes them for a part of one; every so many samples of the log."""
    paths = []
    for seed, number in TWICE:
        cogging = 0.3 * np.sin(order * moved(CLOCK, seed)[0])
        path = write(tmp_path / f"{seed}_{number}.csv", seed, number, 0.3, extra=cogging)
        paths.append(thinned(path, step))
    diagnosis = diagnose(paths, [], options=OPTIONS)
    assert {effect.id for effect in diagnosis.effects} == {"cogging_harmonic", "coulomb_friction"}
    assert not [text for text in diagnosis.findings if "angles by" in text]


@several
def test_what_has_no_name_is_no_delay_and_is_reported_whole(tmp_path: Path) -> None:
    """Friction that fades in each run: a delay takes a little of what it leaves, and no more."""
    paths, more = list[Path](), dict[int, np.ndarray]()
    for seed, number in TWICE:
        more[seed] = 0.3 * np.exp(-CLOCK / 2) * np.tanh(moved(CLOCK, seed)[1] / 0.02)
        paths.append(write(tmp_path / f"{seed}_{number}.csv", seed, number, 0.0, 2e-3, more[seed]))
    diagnosis = diagnose(paths, [], options=OPTIONS)
    assert diagnosis.verdict == "unknown"
    assert not [text for text in diagnosis.findings if "angles by" in text]
    (rest,) = diagnosis.remains
    hidden = np.sqrt(np.mean([v**2 for v in more.values()]))
    assert 0.7 * hidden < rest.rms < 1.1 * hidden


@several
@pytest.mark.parametrize("fitted", [1, 2])
def test_held_out_pass_of_the_fitted_motion_confirms_nothing(fitted: int) -> None:
    """Whatever was taken for friction, it repeats; a held-out run of another motion could refute
    it."""
    one = "one trajectory only: no other motion can refute what is found on it"
    again, other = (said(0.12, TWICE[:fitted], (run,)) for run in ((1, 3), (3, 1)))
    assert one in again.findings
    assert any("held out, but the same motion as" in f for f in again.findings)
    assert not again.effects
    assert any("as runs" in note for note in again.notes) == (fitted == 1)
    assert not [text for text in other.findings if text == one or "held out, but" in text]
    assert {effect.id for effect in other.effects} <= DRY
    assert other.effects


@several
@pytest.mark.parametrize(("friction", "names"), [(0.12, DRY), (0.0, set())])
def test_axis_without_repeats_is_named_by_what_no_noise_could_be(
    friction: float, names: set[str]
) -> None:
    diagnosis = said(friction, ((1, 1), (2, 1)))
    named = {effect.id for effect in diagnosis.effects}
    assert named <= names
    assert bool(named) == bool(names)


def test_base_of_another_name_is_refused_with_those_there_are(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", 1, 1, 0.0)
    with pytest.raises(UsageError, match="there are hexapod, axis, a robot"):
        diagnose([path], options=Options(base="crane"))
