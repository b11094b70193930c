"""Passes of one trajectory find each other, aligned to a fraction of a sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnosis.logs import Channel, Log, group_runs, held_out
from tests.diagnosis.synthetic import TS, motion


def run(seed: int, shift: float, name: str, with_r: bool = False, **meta: str) -> Log:
    """A pass whose motion comes `shift` s later than the first pass of that seed."""
    rng = np.random.default_rng(sum(map(ord, name)))
    fine = motion(12.0, seed=seed, ts=TS / 4)
    t = np.arange(8000) * TS
    theta = np.column_stack([np.interp(t + 1.0 - shift, fine["time"], c) for c in fine["theta"].T])
    noisy = theta + 2e-5 * rng.standard_normal(theta.shape)
    log = replace(Log.of(name, TS, noisy, np.zeros_like(theta)), meta=meta)
    if with_r:
        r = Channel(0.0, TS, theta, np.ones(len(theta), dtype=bool))
        log = replace(log, channels={**log.channels, "r": r})
    return log


@pytest.mark.parametrize("with_r", [True, False])
def test_passes_are_found_and_aligned(with_r: bool) -> None:
    logs = [
        run(1, 0.0, "a1", with_r),
        run(2, 0.0, "b1", with_r),
        run(1, 0.01234, "a2", with_r),
        run(2, -0.4321, "b2", with_r),
    ]
    groups = group_runs(logs)
    assert [[log.name for log in group.logs] for group in groups] == [["a1", "a2"], ["b1", "b2"]]
    shifts = [group.logs[1].shift for group in groups]
    # 8000 samples with 20 urad of noise on 0.3 rad/s leave less than a microsecond
    assert shifts == pytest.approx([0.01234, -0.4321], abs=2e-6)
    assert any("runs with the same" in f.text for f in groups[0].findings)


def test_start_of_the_clock_belongs_to_the_shift() -> None:
    late = run(1, 0.0, "a2")
    moved = {name: replace(c, t0=100.0) for name, c in late.channels.items()}
    (group,) = group_runs([run(1, 0.0, "a1"), replace(late, channels=moved)])
    assert group.logs[1].shift == pytest.approx(100.0, abs=2e-6)


def test_contradicting_metadata_are_found() -> None:
    logs = [
        run(1, 0.0, "a1", trajectory="a", **{"pass": "1"}),
        run(1, 0.1, "a2", trajectory="b", **{"pass": "1"}),
        run(2, 0.0, "a3", trajectory="a", **{"pass": "2"}),
    ]
    first, second = group_runs(logs)
    assert (first.trajectory, second.trajectory) == ("a", "a (2)")
    texts = " | ".join(f.text for f in first.findings)
    assert "named a and b, but they are the same motion" in texts
    assert "same pass number" in texts
    assert any("another motion" in f.text for f in second.findings)


def test_other_payload_is_no_repeat() -> None:
    logs = [run(1, 0.0, "a1", payload="0 kg"), run(1, 0.0, "a2", payload="0.5")]
    assert [len(group.logs) for group in group_runs(logs)] == [1, 1]
    light, heavy = group_runs([logs[0], replace(run(1, 0.0123, "a3"), meta=logs[1].meta)])
    # the same motion all the same, on one clock
    assert light.motion == heavy.motion == light.trajectory != heavy.trajectory
    assert heavy.logs[0].shift == pytest.approx(0.0123, abs=2e-6)
    same = [run(1, 0.0, "a1", payload="0.50 kg"), run(1, 0.0, "a2", payload="0.5")]
    assert [len(group.logs) for group in group_runs(same)] == [2]


def test_single_pass_and_standstill_say_that_nothing_repeats() -> None:
    still = [Log.of(n, TS, 1e-8 * np.ones((8000, 2)), np.zeros((8000, 2))) for n in "ab"]
    groups = group_runs([run(1, 0.0, "a1"), *still])
    assert [len(group.logs) for group in groups] == [1, 1, 1]
    assert all(group.findings[-1].kind == "no-repeat" for group in groups)


def test_repeating_motion_is_not_moved_by_a_period() -> None:
    t = np.arange(8000) * TS
    theta = 0.1 * np.column_stack([np.sin(2 * np.pi * t), np.cos(4 * np.pi * t)])
    logs = [Log.of(n, TS, theta, theta) for n in "ab"]
    (group,) = group_runs(logs)
    assert group.logs[1].shift == pytest.approx(0.0, abs=1e-9)


def passes(*changes: tuple[float, float]) -> list[Log]:
    """Passes of one motion, and a run of another, whose torques are changed: factor and load. They
    are those of an inertia with friction and a spring; the load hangs on the spring's arm."""
    logs = [run(1, 0.01 * k, f"a{k}") for k in range(len(changes))] + [run(2, 0.0, "b")]
    listed = []
    for log, (factor, load) in zip(logs, [*changes, (1.0, 0.0)], strict=True):
        rate = np.gradient(log.theta, TS, axis=0)
        tau = 3.0 * np.tanh(rate) + 5.0 * log.theta + load * np.cos(log.theta)
        listed.append(replace(log, channels=Log.of("", TS, log.theta, factor * tau).channels))
    return listed


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([(1, 0), (1e3, 0)], "a1: torques are 1e+03 times those of a0"),
        ([(1, 0), (1e-3, 0)], "a1: torques are 0.001 times those of a0"),
        ([(-1, 0), (1, 0)], "a0: the torque of axes 1 and 2"),
        ([(1, 0), (1, 0), (-1, 0)], "a2: the torque of axes 1 and 2"),
    ],
)
def test_pass_that_contradicts_the_others_is_named(
    changes: list[tuple[float, float]], said: str
) -> None:
    group, _ = group_runs(passes(*changes))
    (finding,) = [f for f in group.findings if f.kind == "passes"]
    assert str(finding).startswith(said)


@pytest.mark.parametrize("load", [-10.0, 4.0, 30.0])
def test_what_a_pass_carries_is_no_contradiction(load: float) -> None:
    group, _ = group_runs(passes((1, 0), (1, load)))
    assert "passes" not in {f.kind for f in group.findings}


def pushed(log: Log, seed: int, size: float) -> Log:
    """The same motion with a torque [N m] of one second, and of each run another part of this
    size."""
    time = np.arange(8000) * TS
    rng = np.random.default_rng(seed)
    torque = np.sin(2 * np.pi * (time + log.shift)) + size * rng.standard_normal(len(time))
    tau = np.tile(torque[:, None], log.tau.shape[1])
    channel = replace(log.channels["tau_meas"], values=tau)
    return replace(log, channels={**log.channels, "tau_meas": channel})


def test_held_out_pass_of_a_fitted_motion_is_told() -> None:
    fitted = group_runs([pushed(run(seed, 0.0, f"{seed}"), seed, 0.05) for seed in (1, 2)])
    other = [pushed(run(2, 0.0, "pass"), 3, 0.05), pushed(run(3, 0.0, "motion"), 4, 0.05)]
    same, apart = held_out(fitted, group_runs(other))
    assert (same.motion, apart.motion) == (fitted[1].motion, "trajectory 2, held out")
    (said,) = [f for f in same.findings if f.kind == "held-out"]
    assert (said.where, "the same motion as 2" in said.text) == ("pass", True)
    assert not [f for f in apart.findings if f.kind == "held-out"]


def test_held_out_run_that_was_pushed_otherwise_is_no_pass() -> None:
    """Stiff feedback hides in the angles that pulses of force were added."""
    fitted = group_runs([pushed(run(1, 0.0, "first"), 1, 0.0)])
    (other,) = held_out(fitted, group_runs([pushed(run(1, 0.0, "pulses"), 2, 0.4)]))
    assert other.motion not in {group.motion for group in fitted}
    assert not [f for f in other.findings if f.kind == "held-out"]
