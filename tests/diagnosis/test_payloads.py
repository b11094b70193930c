"""Payloads that come and go between runs of an axis, announced or not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.axis import AxisBase
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.result.verdict import Changed, Diagnosis
from flexhex.diagnosis.selection.feedback import noisy
from flexhex.diagnosis.selection.levels import SHARE, Shown, _chances, choices, partitions
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.select import carrying
from flexhex.diagnosis.workflow import diagnose
from tests.diagnosis.single import TS, moved, wanted, write

Array = NDArray[np.float64]
SECONDS = 6.0
CLOCK = np.arange(round(SECONDS / TS)) * TS
RMS = float(wanted(CLOCK, 1).std())
MASS, ARM = 0.4, 0.15
"""A payload on the axis [kg], and its distance [m]."""
Torque = Callable[[int, int], Array | float]
"""Further torque of a motion and a pass."""
several = pytest.mark.sample(4, of="payloads of several kinds")


def carried(motion: int, mass: float = MASS) -> Array:
    """Torque (samples,) [N m] of a payload on the axis."""
    theta, _, acceleration = moved(CLOCK, motion)
    return np.asarray(mass * ARM**2 * acceleration + mass * 9.81 * ARM * np.sin(theta))


def on_axis(
    folder: Path, extra: Torque, heads: Mapping[int, str] | None = None, motions: int = 3
) -> list[Path]:
    """Four passes of each motion; heads: payload that the logs of a pass announce."""
    paths = []
    for motion in range(1, motions + 1):
        for number in range(1, 5):
            path = folder / f"{motion}{number}.csv"
            write(path, motion, number, 0.0, extra=extra(motion, number), seconds=SECONDS)
            payload = (heads or {}).get(number)
            if payload:
                path.write_text(f"# payload: {payload}\n{path.read_text()}")
            paths.append(path)
    return paths


def answer(paths: list[Path], judged: list[Path] | None = None, base: str = "axis") -> Diagnosis:
    return diagnose(paths, judged or [], None, Options(base=base))


def within(change: Changed, value: float) -> bool:
    low, high = change.estimate.ci95
    return low <= value <= high


@several
@pytest.mark.parametrize("heavy", [(2, 4), (1, 3), (1, 2, 4)], ids=str)
def test_payload_on_some_passes_is_found_with_its_runs(
    heavy: tuple[int, ...], tmp_path: Path
) -> None:
    paths = on_axis(tmp_path, lambda motion, k: carried(motion) * (k in heavy))
    diagnosis = answer(paths)
    assert diagnosis.verdict == "changed"
    assert not diagnosis.effects
    changed = {change.parameter: change for change in diagnosis.changed}
    inertia, weight = changed["payload.J[1]"], changed["payload.g_s[1]"]
    assert within(inertia, MASS * ARM**2)
    assert within(weight, MASS * 9.81 * ARM)
    # twice two percent: nobody would call a wide interval an answer
    assert np.ptp(inertia.estimate.ci95) < 0.04 * MASS * ARM**2
    assert sorted(inertia.runs) == [str(p) for p in paths if int(p.stem[1]) in heavy]


@pytest.mark.parametrize("heavy", [False, True])
def test_payload_that_keeps_the_base_model_from_fitting_is_sought_alone(
    heavy: bool, tmp_path: Path
) -> None:
    paths = on_axis(tmp_path, lambda motion, k: carried(motion) * (heavy and k > 2))
    base, run_set, _ = run_set_of(paths, [], None, Options(base="axis"))
    bench = Bench(fitted(base, run_set.runs)[0], ())
    assert bool(carrying(bench).model.loads) == heavy


def test_weight_of_what_slides_is_an_offset() -> None:
    base = AxisBase(2, TS, (ROTARY, LINEAR))
    names = [base.linear[place].name for place in base.payload]
    assert names == ["J[1]", "g_s[1]", "g_c[1]", "o[2]", "m[2]"]


@several
def test_cogging_beside_a_payload_is_found_with_it(tmp_path: Path) -> None:
    def both(motion: int, number: int) -> Array:
        cogging = 0.01 * RMS * np.sin(53.0 * moved(CLOCK, motion)[0] + 0.4)
        return np.asarray(cogging + carried(motion) * (number > 2))

    diagnosis = answer(on_axis(tmp_path, both))
    assert [effect.id for effect in diagnosis.effects] == ["cogging_harmonic"]
    assert diagnosis.effects[0].parameters["order"].value == pytest.approx(53.0, abs=0.3)
    assert within(diagnosis.changed[0], MASS * ARM**2)


@several
def test_trajectories_of_one_load_alone_are_sorted_too(tmp_path: Path) -> None:
    """About their own mean all of their passes are alike."""
    paths = on_axis(tmp_path, lambda m, k: carried(m) * (m == 2 or (m == 3 and k > 2)))
    (runs,) = {change.runs for change in answer(paths).changed}
    assert [Path(run).stem for run in runs] == ["21", "22", "23", "24", "33", "34"]


@several
def test_two_payloads_are_two(tmp_path: Path) -> None:
    """Whichever way they are told: by what is beyond the lightest, or by what is added."""
    sizes = {1: 0.0, 2: 0.0, 3: 1.0, 4: 1.6}
    paths = on_axis(tmp_path, lambda motion, k: sizes[k] * carried(motion))
    diagnosis = [c for c in answer(paths).changed if c.parameter.endswith(".J[1]")]
    assert len(diagnosis) == 2
    for path in paths:
        carried_there = sum(c.estimate.value for c in diagnosis if str(path) in c.runs)
        wanted_there = sizes[int(path.stem[1])] * MASS * ARM**2
        assert carried_there == pytest.approx(wanted_there, abs=0.02 * MASS * ARM**2)


@several
def test_three_levels_at_even_distances_are_distinguished(tmp_path: Path) -> None:
    """No cut in two stands out among them."""
    sizes = {1: 0.0, 2: 1.0, 3: 1.0, 4: 2.0}
    diagnosis = answer(on_axis(tmp_path, lambda motion, k: sizes[k] * carried(motion)))
    first, second = (c for c in diagnosis.changed if c.parameter.endswith(".J[1]"))
    assert (len(first.runs), len(second.runs)) == (6, 3)
    assert within(first, MASS * ARM**2)
    assert within(second, 2 * MASS * ARM**2)


def test_runs_of_one_motion_that_differ_by_noise_are_no_levels() -> None:
    """Though another motion shows another amount: it may differ in what the model lacks."""
    which = np.array([0, 0, 1, 1, 2, 2])
    amounts = np.array([[0.0], [0.1], [90.0], [90.2], [1.0], [1.1]])
    split = np.array([1, 1, 0, 2, 1, 1])
    assert _chances(amounts, split, which, 0.01)[0] > np.log(0.1)
    assert choices(split, which) == 90
    assert choices(np.array([0, 0, 1, 1, 0, 0]), which) == 3


def test_two_trajectories_that_show_the_same_difference_show_a_level() -> None:
    """Unless it is no larger than what anybody would call a payload."""
    which, split = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    amounts = np.array([[-50.0, 3.0], [50.0, -2.0], [-49.0, 2.0], [51.0, -4.0]])
    assert _chances(amounts, split, which, 1.0)[0] < np.log(1e-3)
    assert _chances(amounts, split, which, 100.0**2)[0] > np.log(0.1)


def test_run_that_excites_nothing_has_no_share() -> None:
    """A run at rest among others; and ends of a cut that do not differ."""
    S, delta = np.array([np.eye(2), np.zeros((2, 2))]), np.array([3.0, 4.0])
    shown = Shown(S, np.array([0.5 * delta, 0 * delta]), 1.0)
    with np.errstate(all="raise"):
        # a half, less what the mean run weighs
        assert shown.along(delta) == pytest.approx([0.5 / (1 + SHARE), 0.0])
        assert shown.along(0 * delta) == pytest.approx([0.0, 0.0])


def test_partitions_are_counted() -> None:
    """Five runs: 15 ways into two, 25 into three; as listed by Stirling."""
    assert [partitions(5, parts) for parts in (1, 2, 3, 4, 5)] == [1, 15, 25, 10, 1]


@several
def test_announced_payload_is_no_effect(tmp_path: Path) -> None:
    """An axis knows nothing of it, whatever the head says."""
    paths = on_axis(tmp_path, lambda motion, k: carried(motion) * (k > 2), {3: "0.4", 4: "0.4"})
    diagnosis = answer(paths)
    assert diagnosis.verdict == "none"
    assert not diagnosis.changed


@several
def test_amounts_that_differ_from_run_to_run_are_no_payload(tmp_path: Path) -> None:
    """Every run has an amount of its own: they do not fall into two."""
    rng = np.random.default_rng(7)
    amount = {(m, k): rng.standard_normal() for m in range(1, 4) for k in range(1, 5)}
    paths = on_axis(tmp_path, lambda motion, k: 0.1 * amount[motion, k] * carried(motion))
    assert not answer(paths).changed


@pytest.mark.parametrize("light", ["0", ""], ids=["announced", "head says nothing"])
def test_groups_that_differ_in_payload_are_one_trajectory(light: str, tmp_path: Path) -> None:
    """Left out together; passes of one load are each other's partners."""
    heads = {1: light, 2: light, 3: "0.4", 4: "0.4"}
    paths = on_axis(tmp_path, lambda motion, k: carried(motion) * (k > 2), heads, 2)
    base, run_set, _ = run_set_of(paths, [], None, Options(base="axis"))
    model, _, _ = fitted(base, run_set.runs)
    assert len(np.unique(model.layout.fold)) == 2
    loads = np.concatenate(
        [
            np.full(kept.sum(), b.run.payload)
            for b, kept in zip(model.blocks, model.kept, strict=True)
        ]
    )
    assert set(loads) == {0.0, 0.4}
    np.testing.assert_array_equal(loads[model.layout.partner], loads)
    assert (model.layout.partner != np.arange(len(loads))).mean() > 0.99


@pytest.mark.parametrize("heavy", [False, True])
def test_feedback_answers_noise_beside_a_payload_that_leaves_no_repeats(
    heavy: bool, tmp_path: Path
) -> None:
    """Noise that moves the joints would be named."""
    paths = [p for p in on_axis(tmp_path, lambda motion, k: 0.0) if p.stem[1] in "12"]
    base, run_set, _ = run_set_of(paths, [], None, Options(base="axis"))
    runs = [replace(run, loads=int(heavy and k % 2)) for k, run in enumerate(run_set.runs)]
    model, _, _ = fitted(base, runs)
    assert bool(noisy(Rows.of(model))) == heavy


@several
def test_held_out_runs_carry_what_suits_them(tmp_path: Path) -> None:
    paths = on_axis(tmp_path, lambda motion, k: carried(motion) * (k > 2), motions=3)
    diagnosis = answer(paths[:8], paths[8:])
    residual = diagnosis.residual.held_out
    assert residual["after"][0] == pytest.approx(residual["non_repeatable"][0], rel=0.05)
    assert residual["nominal"][0] > 10 * residual["after"][0]
