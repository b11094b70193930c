"""The next experiment: the reference block's motion, within limits, as a file that reads back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.logs import Log, read_log
from flexhex.diagnosis.planning.experiment import (
    BEFORE,
    USED,
    Array,
    Limits,
    make,
    with_experiments,
)
from flexhex.diagnosis.planning.trajectory import Trajectory, read_trajectory, write_trajectory
from flexhex.fmus.common.effects import Experiment, library
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.fmus.common.machine.machine import Machine
from tests.blocks.test_reference import CHIRP, MULTISINE, RANDOM, TRIANGLE, TS, one_pass
from tests.compare import assert_close
from tests.flexhex.diagnoses import AMBIGUOUS, BASIC

SLOW = 2e-3
"""Sample time [s] of tests for which the exact one does not matter."""
TIGHT = Limits(
    low=np.array([-0.3, 0.1]),
    high=np.array([1.1, 0.15]),
    speed=np.array([0.4, 0.04]),
    acceleration=np.array([3.0, 0.5]),
    amplitude=np.array([0.5, 0.02]),
)
"""An arm of two axes: a wide one off the middle, and one that hardly moves."""


def rates(r: Array, ts: float) -> tuple[Array, Array]:
    """Speed and acceleration by differences."""
    rate = np.diff(r, axis=0) / ts
    return rate, np.diff(rate, axis=0) / ts


@pytest.mark.parametrize(
    ("kind", "number", "parameters"),
    [
        ("random", RANDOM, {"duration": 3.0, "seed": 9}),
        ("triangle", TRIANGLE, {"duration": 5.0, "speed": 0.3, "rounding": 2.0}),
        ("multisine", MULTISINE, {"duration": 3.0, "f_base": 0.7, "n_sines": 5, "seed": 4}),
        ("chirp", CHIRP, {"duration": 3.0, "f0": 0.5, "f1": 6.0}),
    ],
)
def test_motion_is_that_of_the_reference_block(
    kind: str, number: int, parameters: dict[str, float], machine: Machine
) -> None:
    """Angles are rounded to 1e-10 rad, hence half of that and the last bits of a sine."""
    t, (r, _, _) = one_pass(kind=number, amplitude=[0.1] * 6, **parameters)
    spec = Experiment(kind, {**parameters, "amplitude": 0.1})
    motion = make(spec, Limits.of_machine(machine), TS)
    first = round(BEFORE / TS)
    count = len(t) - 1
    assert_close(motion.r[first : first + count], r[:count], atol=6e-11, rtol=0)


@pytest.mark.parametrize("name", library())
def test_every_experiment_keeps_within_the_stroke_and_rests_at_both_ends(
    name: str, machine: Machine
) -> None:
    motion = make(library()[name].spec, Limits.of_machine(machine), SLOW)
    assert np.abs(motion.r).max() <= USED * machine.geometry.stroke
    assert np.abs(motion.r).max() > 1e-3
    rest = round(0.9 / SLOW)
    assert np.abs(motion.r[:rest]).max() == 0
    assert np.abs(motion.r[-rest:]).max() == 0


@pytest.mark.parametrize("name", library())
def test_every_experiment_keeps_the_limits_of_another_machine(name: str) -> None:
    """Differences see at most the true extremes; 1e-10 rad over SLOW^2 is 2.5e-5 rad/s2."""
    motion = make(library()[name].spec, TIGHT, SLOW)
    rate, change = rates(motion.r, SLOW)
    assert (motion.r >= TIGHT.low).all()
    assert (motion.r <= TIGHT.high).all()
    assert (np.abs(rate).max(axis=0) <= TIGHT.speed).all()
    assert (np.abs(change).max(axis=0) <= TIGHT.acceleration).all()
    assert (np.ptp(motion.r, axis=0) > 1e-5).all(), "both axes move, if only at 40 Hz"
    assert motion.r[0] == pytest.approx(TIGHT.middle, abs=1e-10)


def test_a_limit_is_used_and_not_only_kept() -> None:
    """A random motion as large as the speed allows: 95 % of it, by differences a little less."""
    motion = make(Experiment("random", {"amplitude": 1.0}), TIGHT, SLOW)
    rate, _ = rates(motion.r, SLOW)
    used = np.abs(rate).max(axis=0) / TIGHT.speed
    assert (used <= USED).all()
    assert used.max() > USED - 0.01


def test_axis_that_cannot_move_rests() -> None:
    fixed = replace(TIGHT, low=np.array([0.0, 0.2]), high=np.array([0.0, 0.3]))
    for kind in ("random", "triangle", "multisine", "chirp"):
        motion = make(Experiment(kind, {"duration": 4.0}), fixed, SLOW)
        assert np.ptp(motion.r[:, 0]) == 0
        assert np.ptp(motion.r[:, 1]) > 1e-4


@pytest.mark.parametrize(("speed", "acceleration"), [(1e-4, 3.0), (0.4, 1e-6), (1e-4, 1e-6)])
def test_triangle_of_a_slow_axis_ends_within_four_durations(
    speed: float, acceleration: float
) -> None:
    slow = replace(TIGHT, speed=np.full(2, speed), acceleration=np.full(2, acceleration))
    motion = make(Experiment("triangle", {"duration": 10.0}), slow, SLOW)
    assert 10 < SLOW * len(motion.r) <= 44
    assert (np.ptp(motion.r, axis=0) > 1e-6).all()


def test_unknown_kind_is_refused() -> None:
    with pytest.raises(UsageError, match="'spiral' is no kind of experiment, there are random"):
        make(Experiment("spiral"), TIGHT)


def trajectory() -> Trajectory:
    """A short one with metadata."""
    spec = Experiment("triangle", {"duration": 6.0, "speed": 0.2}, ((0.0, 0.0), (25.0, 1.5)))
    return make(spec, TIGHT, 1e-3, "next-x")


def test_file_reads_back_exactly(tmp_path: Path) -> None:
    motion = trajectory()
    loaded = read_trajectory(write_trajectory(motion, tmp_path / "new" / "x.csv"))
    assert np.array_equal(loaded.r, motion.r)
    assert loaded.ts == pytest.approx(motion.ts, rel=1e-9)
    assert dict(loaded.meta) == dict(motion.meta)
    assert loaded.meta["payloads"] == "0 kg, 1.5 kg"
    lines = (tmp_path / "new" / "x.csv").read_text().splitlines()
    assert lines[len(motion.meta) : len(motion.meta) + 2] == ["time,r[1],r[2]", "s,rad,rad"]


@pytest.mark.parametrize("kind", ["random", "triangle", "multisine", "chirp"])
@pytest.mark.parametrize("limits", [TIGHT, replace(TIGHT, kinds=(ROTARY, LINEAR))])
def test_head_of_a_file_says_what_its_rows_do(kind: str, limits: Limits) -> None:
    """The limits make the motion smaller than the effect asks for; three digits, and differences
    over 2 ms, hence 1 %."""
    spec = Experiment(kind, {"amplitude": 0.9, "speed": 3.0, "rounding": 9.0, "duration": 8.0})
    motion = make(spec, limits, SLOW)
    moved = motion.r - limits.middle
    for name, values in zip(
        ("amplitude", "speed", "acceleration"), (moved, *rates(moved, SLOW)), strict=True
    ):
        said = [float(part.split()[0]) for part in motion.meta[name].split(", ")]
        assert said == pytest.approx(np.abs(values).max(axis=0), rel=0.01)
    assert "rounding" not in motion.meta
    assert motion.meta["speed"].endswith("m/s" if limits.kinds else "rad/s")


def test_file_is_the_same_every_time(tmp_path: Path) -> None:
    first, second = (write_trajectory(trajectory(), tmp_path / n) for n in ("a.csv", "b.csv"))
    assert first.read_bytes() == second.read_bytes()
    other = make(Experiment("multisine", {"seed": 2, "duration": 4.0}), TIGHT, SLOW)
    again = make(Experiment("multisine", {"seed": 3, "duration": 4.0}), TIGHT, SLOW)
    assert np.abs(other.r - again.r).max() > 1e-3


def test_file_with_measured_columns_beside_it_is_a_log(tmp_path: Path) -> None:
    """What a user does: runs it, and logs angles and torques beside r."""
    motion = trajectory()
    path = write_trajectory(motion, tmp_path / "x.csv")
    head = len(motion.meta)
    lines = path.read_text().splitlines()
    lines[head] += ",theta[1],theta[2],tau_meas[1],tau_meas[2]"
    lines[head + 1] += ",rad,rad,N m,N m"
    rows = [
        f"{line},{a},{b},{a},{b}" for line, (a, b) in zip(lines[head + 2 :], motion.r, strict=True)
    ]
    path.write_text("\n".join([*lines[: head + 2], *rows]))
    log = read_log(path)
    assert np.array_equal(log["r"].values, motion.r)
    assert log.trajectory == "next-x"


def test_log_without_r_gives_its_angles_and_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "\n".join(f"{0.01 * k:.2f},{k},{k}" for k in range(20))
    path.write_text(f"time,theta[1],tau_meas[1]\ns,deg,N m\n{rows}\n")
    assert read_trajectory(path).r[2, 0] == pytest.approx(np.deg2rad(2))
    path.write_text(f"time,x[1],y[1]\ns,rad,N m\n{rows}\n")
    with pytest.raises(LogError, match=r"no channels r\[1\]"):
        read_trajectory(path)
    with pytest.raises(LogError, match="no such file"):
        read_trajectory(tmp_path / "gone.csv")
    with pytest.raises(LogError, match="unknown kind"):
        read_trajectory(Path(__file__))


def test_limits_of_logs_are_what_was_seen() -> None:
    """sin(2 pi t) / 10: speed 0.2 pi; acceleration 0.4 pi^2, both a little less by differences."""
    t = 1e-3 * np.arange(4000)
    theta = np.column_stack([0.1 * np.sin(2 * np.pi * t), 0.5 + 0 * t])
    limits = Limits.of_logs([Log.of("a", 1e-3, theta, theta), Log.of("b", 1e-3, -theta, theta)])
    assert limits.high == pytest.approx([0.1, 0.5], rel=1e-4)
    assert limits.low == pytest.approx([-0.1, -0.5], rel=1e-4)
    assert limits.speed == pytest.approx([0.2 * np.pi, 0], rel=0.01)
    assert limits.acceleration == pytest.approx([0.4 * np.pi**2, 0], rel=0.01)


def test_effects_with_rivals_get_a_file_and_others_none(tmp_path: Path) -> None:
    (effect,) = AMBIGUOUS.effects
    asking = replace(AMBIGUOUS, effects=(replace(effect, experiment=None),))
    limits = replace(TIGHT, speed=np.array([2.0, 2.0]))
    (planned,) = with_experiments(asking, limits, tmp_path, SLOW).effects
    assert planned.experiment == str(tmp_path / "next-coulomb_friction.csv")
    assert read_trajectory(tmp_path / "next-coulomb_friction.csv").meta["kind"] == "triangle"
    stranger = replace(AMBIGUOUS, effects=(replace(effect, id="my_own_effect"),))
    assert with_experiments(stranger, limits, tmp_path, SLOW).effects == stranger.effects
    assert with_experiments(BASIC, limits, tmp_path, SLOW).effects == BASIC.effects
