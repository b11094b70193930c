"""What planned motions could show: figures against least squares by hand, on one axis and two."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.hexapod import HexapodBase
from flexhex.diagnosis.planning.isolability import NOISE, Isolability, isolability
from flexhex.diagnosis.planning.trajectory import Trajectory, write_trajectory
from flexhex.diagnosis.regression.gram import ABSORBED
from flexhex.diagnosis.workflow import Options, silent
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.single import moved

Array = NDArray[np.float64]
TS = 1e-3
AXIS = Options(base="axis")


def motion(seeds: tuple[int, ...], seconds: float = 8.0) -> Array:
    """Smooth angles (samples, axes)."""
    t = np.arange(round(seconds / TS)) * TS
    return np.column_stack([moved(t, seed)[0] for seed in seeds])


def isolability_of(folder: Path, *planned: Array) -> Isolability:
    paths = [
        write_trajectory(Trajectory(f"p{k}", TS, r), folder / f"p{k}.csv")
        for k, r in enumerate(planned)
    ]
    return isolability(paths, None, AXIS, silent)


def place(result: Isolability, name: str) -> int:
    return result.effects.index(name)


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Isolability:
    return isolability_of(tmp_path_factory.mktemp("one"), motion((1,)), motion((2,)))


def test_every_effect_is_wholly_explained_by_itself(one: Isolability) -> None:
    assert np.array_equal(np.diag(one.share), np.ones(len(one.effects)))
    assert one.share.min() >= 0
    assert one.share.max() <= 1
    # the maximum of a search over shapes that has the truth in it, or near
    assert "coulomb_friction" in one.effects


def test_one_axis_alone_has_no_coupling(one: Isolability, tmp_path: Path) -> None:
    assert "cross_coupling" not in one.effects
    both = isolability_of(tmp_path, 0.1 * motion((1, 3)))
    assert (one.n, both.n, both.axis) == (1, 2, both.axes[0][0])
    at = place(both, "cross_coupling")
    assert np.isfinite(both.smallest[at])
    assert both.axes[at] == (int(np.argmax(np.std(motion((1, 3)), axis=0))) + 1,)


def test_smallest_effect_is_what_least_squares_tells(one: Isolability) -> None:
    """Quadratic drag beside the six terms of an axis, by hand: smoothing hardly moves it."""
    rows, own = [], []
    for seed in (1, 2):
        t = np.arange(round(8.0 / TS)) * TS
        theta, rate, acceleration = moved(t, seed)
        # as the base has it: 0.2 s of settling, a window at either end, a row each 6.25 ms
        at = np.arange(0.23, t[-1] - 0.025, 0.00625)
        terms = (np.ones_like(t), acceleration, rate, theta, np.sin(theta), np.cos(theta))
        rows.append(np.column_stack([np.interp(at, t, term) for term in terms]))
        own.append(np.interp(at, t, rate * np.abs(rate)))
    B, drag = np.vstack(rows), np.concatenate(own)
    left = drag - B @ np.linalg.lstsq(B, drag, rcond=None)[0]
    # a fall of 4 x 25 in units of the noise
    wanted = np.sqrt(100 / (left @ left)) * np.sqrt((drag**2).mean()) * NOISE
    # the base has a free delay beside the terms and smooths over 25 ms
    assert one.smallest[place(one, "quadratic_drag")] == pytest.approx(wanted, rel=0.1)


def test_what_the_base_takes_up_has_no_row(one: Isolability) -> None:
    """A torque that is too large throughout is another inertia of an axis."""
    assert "drive_gain" not in one.effects


def test_what_is_never_found_is_null_in_data(one: Isolability) -> None:
    at = place(one, "coulomb_friction")
    smallest = one.smallest.copy()
    smallest[at] = np.nan
    blind = replace(one, smallest=smallest)
    assert blind.data()["smallest"]["values"][at] is None


def test_lag_and_delay_of_an_only_axis_are_the_loggers(one: Isolability) -> None:
    """The base model's delay takes them up as far as its tolerance goes."""
    least = 20 * one.smallest[place(one, "coulomb_friction")]
    for name in ("drive_lag", "time_delay"):
        assert not one.smallest[place(one, name)] <= least


def test_no_figure_is_that_of_rounding(one: Isolability) -> None:
    """What is found at all is found at torques that a drive has, not at 1e7 N m."""
    finite = one.smallest[np.isfinite(one.smallest)]
    assert len(finite) > 8
    assert finite.max() < NOISE * 10 / np.sqrt(ABSORBED)


def test_effects_that_need_torque_are_seen_where_no_machine_is_known(one: Isolability) -> None:
    assert np.isfinite(one.smallest[place(one, "torque_ripple")])


def test_friction_at_one_speed_alone_is_damping(tmp_path: Path) -> None:
    t = np.arange(round(8.0 / TS)) * TS
    triangle = 0.3 * np.abs((t / 2.0) % 2 - 1)
    listed = [
        isolability_of(tmp_path / str(k), k * triangle[:, None], triangle[:, None]) for k in (1, 3)
    ]
    least = [one.smallest[place(one, "quadratic_drag")] for one in listed]
    assert not least[0] < 5 * least[1]


def test_more_of_the_same_motion_finds_less(one: Isolability, tmp_path: Path) -> None:
    twice = isolability_of(tmp_path, motion((1,)), motion((2,)), motion((1,)), motion((2,)))
    at = place(one, "coulomb_friction")
    assert twice.smallest[at] == pytest.approx(one.smallest[at] / np.sqrt(2), rel=0.02)


def test_all_effects_of_the_library_have_a_row(one: Isolability) -> None:
    effects = library().items()
    # a hexapod's rotors are no bodies of their own, and its joints have offset, spring and damping
    known = {name for name, e in effects if e.acts_on != "mechanism" and not e.geared}
    assert set(one.effects) == known - {"cross_coupling", "drive_gain", *HexapodBase.holds}


def test_plan_that_is_too_short_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="at least"):
        isolability_of(tmp_path, motion((1,), 0.5))
