"""The experiments: their arithmetic on constructed runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.estimation.motion import MotionModel, SparseRegressor
from flexhex.experiments import estimates, experiment, hysteresis, payload
from flexhex.experiments import repeatability as repeat
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.reference.interface import MAX_PAYLOADS
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, Case
from flexhex.simulation.metrics import Figures, rms
from flexhex.simulation.passes import non_repeatable
from flexhex.simulation.runs import samples, variant
from flexhex.ssp.results import Group, Result
from tests.conftest import MACHINE_FILE

RNG = np.random.default_rng(5)


def passes(n: int, sigma: float) -> Any:
    """The same sine n times with noise of its own each time (n, samples, 2)."""
    common = np.sin(np.linspace(0, 20, 4000))[:, None] * [1.0, 2.0]
    return common + sigma * RNG.standard_normal((n, 4000, 2))


@pytest.mark.parametrize("n", [2, 3, 8])
def test_non_repeatable_part_is_the_noise_whatever_the_passes(n: int) -> None:
    """2 % hold 5 standard deviations of an RMS of 16000 values or more; without the factor it
    would be sqrt((n - 1) / n) of it. It is the figure of Table I, column by column."""
    values = passes(n, 0.1)
    left = repeat.deviations(values)
    assert repeat.unbiased(n) * rms(left) == pytest.approx(0.1, rel=0.02)
    table = non_repeatable(values.reshape(-1, 2), n)
    for k in range(2):
        assert repeat.unbiased(n) * rms(left[..., k]) == pytest.approx(table[k], rel=1e-12)


def test_mean_and_deviations_add_up_in_squares() -> None:
    """Exactly: the mean of the passes is orthogonal to what is left of them."""
    values = passes(3, 0.3)
    parts = rms(values.mean(axis=0)) ** 2 + rms(repeat.deviations(values)) ** 2
    assert rms(values) ** 2 == pytest.approx(parts, rel=1e-12)


def test_passes_are_cut_at_their_begins() -> None:
    signal = np.tile(np.arange(10.0)[:, None], (3, 2))
    cut = repeat.by_pass(np.vstack([signal, signal[:1]]), 3)
    assert cut.shape == (3, 10, 2)
    assert (cut[:, :, 0] == np.arange(10.0)).all()
    assert not repeat.deviations(cut).any()


def test_share_of_power_is_one_minus_the_square() -> None:
    """0.0016 and 0.0117 N m give 86.3 % of RMS values; of mean squares it is 98.1 %."""
    apart, adaptive = (Figures(1.0, tau, *[1.0] * 6) for tau in (0.0016, 0.0117))
    none = np.zeros((1, 1, 1))
    result = repeat.Repeatability(
        3, adaptive, apart, apart, adaptive, none[0, 0], none, none, none[0]
    )
    assert result.repeatable_share == pytest.approx(0.863, abs=5e-4)
    assert result.repeatable_share_of_power == pytest.approx(0.981, abs=5e-4)


def loop(c: float, slope: float, offset: float) -> tuple[Any, Any]:
    """Two cycles of a triangle and a torque that jumps by 2 c where it turns."""
    quarter = np.linspace(0, 0.2, 500, endpoint=False)
    up = np.concatenate([-0.2 + quarter, quarter])
    cycle = np.concatenate([quarter, -up, up[:500]])
    theta = np.concatenate([cycle, cycle])
    direction = np.sign(np.diff(theta, append=1.0))
    return theta, offset + slope * theta + c * direction + 0.1 * np.cos(36 * theta)


def test_loop_loses_its_own_line_and_keeps_its_width() -> None:
    """Lines differ, everything else is alike: nothing is missed, and 2 c is the width."""
    theta, measured = loop(0.07, 0.5, -1.6)
    _, model = loop(0.07, 0.3, -1.0)
    split = hysteresis.split(theta, measured, model, 1, 0.05)
    assert split.missed < 1e-12
    assert split.line_measured[1] - split.line_model[1] == pytest.approx(0.2, abs=1e-9)
    assert split.line_measured[0] - split.line_model[0] == pytest.approx(-0.6, abs=1e-9)
    assert split.width("measured") == pytest.approx(0.14, rel=0.01)
    _, thin = loop(0.05, 0.5, -1.6)
    assert hysteresis.split(theta, measured, thin, 1, 0.05).missed == pytest.approx(0.02, rel=0.01)


def test_branches_go_one_way() -> None:
    split = hysteresis.split(*loop(0.07, 0.5, 0.0), loop(0.07, 0.5, 0.0)[1], 1, 0.05)
    assert (np.diff(split.forward.theta) > 0).all()
    assert (np.diff(split.backward.theta) < 0).all()


def test_predicted_torque_is_phi_times_p() -> None:
    dense = RNG.standard_normal((20, 3, 5)) * (RNG.random((3, 5)) < 0.6)
    at = np.nonzero(dense[0])
    columns = SparseRegressor(dense[:, at[0], at[1]], at[0], at[1], (3, 5))
    p = RNG.standard_normal(5)
    for joint in range(3):
        assert hysteresis.predicted(columns, p, joint) == pytest.approx(dense[:, joint] @ p)


def test_angle_and_torque_are_of_one_instant(machine: Machine) -> None:
    """A torque that is a straight line in the angle leaves nothing: one sample of shift would
    leave a loop of slope * speed * 0.5 ms = 1e-4 N m."""
    base, speed = machine.timing.base, 0.5
    t = np.arange(round((SETTLE + 3.2) / base)) * base
    theta = np.zeros((len(t), machine.n_arms))
    phase = 2 * np.pi * np.maximum(t - SETTLE, 0) / 1.6
    theta[:, 0] = 0.1 * np.sin(phase)
    tau = np.ones_like(theta) + 2.0 * theta
    result = Result({"a": Group(1, base, {"plant.theta": theta, "plant.tau_meas": tau})})
    p = np.zeros(len(parameters(machine)))
    actual = hysteresis.evaluate(MotionModel(machine), p, result, 0, speed)
    assert actual.line_measured == pytest.approx((1.0, 2.0), abs=1e-9)
    assert actual.size < 1e-9
    assert abs(actual.width("measured")) < 1e-9


def test_mask_lets_the_end_effector_adapt_alone(machine: Machine) -> None:
    mask = payload.mask(machine)
    names = [par.name for par, on in zip(parameters(machine), mask, strict=True) if on]
    assert len(names) == 10
    assert all(name.startswith("end_effector.") for name in names)


def test_payload_wants_an_end_effector() -> None:
    """A machine without a platform has no mass to change: said before anything runs."""
    alone = Builder(MACHINE_FILE.with_name("tflex-actuators.toml"), MACHINE_FILE.parent).machine
    with pytest.raises(MachineError, match=r"no end-effector .*: leave"):
        payload.mask(alone)


def test_payload_times_start_with_the_simulation() -> None:
    times, masses = payload.schedule(50.0, 0.00025)
    starts = payload._starts(times, masses)
    entries = np.asarray(starts["payload_time"])
    assert starts["payload_count"] == len(masses) <= MAX_PAYLOADS == len(entries)
    assert entries[0] == SETTLE
    assert entries[len(times) - 1] == SETTLE + times[-1] < SETTLE + 50.0
    assert (masses[0], masses[-1]) == (0.0, 0.0)


def test_model_itself_is_projected_onto_its_own_parameters(machine: Machine, fmu_dir: Path) -> None:
    """plant.fmu holds the file's values, whose arms are alike: projecting loses nothing."""
    result = estimates.projected(machine, estimates.start_values(fmu_dir / "plant.fmu"))
    assert result == pytest.approx(base_parameters(machine), rel=1e-9, abs=1e-12)


def test_truth_differs_from_the_file_as_the_truth_file_says(
    machine: Machine, fmu_dir: Path
) -> None:
    """Actuator terms by 5 %: of 132 draws the RMS lies within 20 % of that."""
    result = estimates.projected(machine, estimates.start_values(fmu_dir / "machine.fmu"))
    nominal = base_parameters(machine)
    assert rms((result / nominal - 1)[:132]) == pytest.approx(0.05, rel=0.2)


def test_warm_parameters_act_like_the_drift(machine: Machine) -> None:
    """(1 - gain s) tau - drift s = Phi p: what hidden.h subtracts from the motor torque."""
    n, cold = machine.n_arms, base_parameters(machine)
    drift = RNG.standard_normal(n)
    values = {
        "drift_torque": drift,
        "drift_gain": np.array([0.02]),
        "drift_time": np.array([600.0]),
    }
    s = 1 - np.exp(-900 / 600)
    Phi = RNG.standard_normal((n, len(cold)))
    offsets = [k for k, par in enumerate(parameters(machine)) if par.name.endswith(".o")]
    Phi[:, offsets] = np.eye(n)
    tau = Phi @ estimates.warmed(machine, cold, values, 900.0)
    assert (1 - 0.02 * s) * tau - drift * s == pytest.approx(Phi @ cold)
    assert estimates.warmed(machine, cold, values, 0.0) == pytest.approx(cold)


def test_variant_changes_what_it_names_alone() -> None:
    base = Case("a", "b", "machine", 1.0, {"reference": {"seed": 1.0, "passes": 1.0}, "W": {}})
    built = variant(base, "c", "d", 2.0, {"reference": {"passes": 3.0}, "plant": {"age": 1.0}})
    assert built.starts == {
        "reference": {"seed": 1.0, "passes": 3.0},
        "W": {},
        "plant": {"age": 1.0},
    }
    assert base.starts["reference"]["passes"] == 1.0
    assert (built.name, built.title, built.duration) == ("c", "d", 2.0)


def test_samples_begin_with_the_first_pass() -> None:
    """The sample at that time is the first, though 3 * 0.1 / 0.1 is a little more than 3."""
    group = Group(1, 0.1, {"a": np.arange(40.0)[:, None]})
    t, values, ts = samples(Result({"0.1": group}), "a", 3 * 0.1)
    assert (float(values[0, 0]), ts) == (3.0, pytest.approx(0.1))
    assert t[0] == pytest.approx(0.0, abs=1e-12)


def test_unknown_experiment_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match="no experiment 'fig2': there are repeatability, "):
        experiment("fig2")
