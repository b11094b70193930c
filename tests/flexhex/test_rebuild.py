"""Replay and rebuild: a model that is right leaves no residual, one that lacks something does."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnose.rebuild import Rebuilt, rebuild
from flexhex.diagnose.replay import plant_values, replay
from flexhex.diagnosis.estimation.identify import Fit
from flexhex.diagnosis.logs import Log, read_log
from flexhex.diagnosis.machine_files.extend import extended_file
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Diagnosis, Named, Residual
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.bodies import Mechanism, nominal_mechanism
from flexhex.fmus.common.model.parameters import base_parameters, regrouped
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import extra_cases
from flexhex.ssp.executor import run
from tests.conftest import MACHINE_FILE, OUT, one_at_a_time

Array = NDArray[np.float64]
SECONDS = 4.0
K_3, AXIS = 6.0, 2
"""The effect that the machine of these tests has and its nominal model lacks."""


def estimate(value: float, unit: str) -> Estimate:
    return Estimate(value, (value - 0.1, value + 0.1), unit)


def stiffness(k_3: float) -> Named:
    parts = ((AXIS, {"k_3": estimate(k_3, "N m/rad3")}),)
    return Named("cubic_stiffness", "cubic stiffness", (AXIS,), {}, parts)


def tilt(angle: float) -> Named:
    """Wrong: nothing is tilted."""
    values = {"tilt_x": estimate(angle, "rad"), "tilt_y": estimate(0.0, "rad")}
    return Named("gravity_tilt", "tilted base", (), {}, ((0, values),))


def diagnosis(*effects: Named) -> Diagnosis:
    nothing = np.full(6, np.nan)
    return Diagnosis("named", effects, (), Residual(("N m",) * 6, *(nothing for _ in range(7))))


@pytest.fixture(scope="module")
def stiff() -> Builder:
    """A machine with cubic stiffness on one axis; no truth file, plant.fmu stands for it."""
    folder = OUT / "rebuild"
    folder.mkdir(parents=True, exist_ok=True)
    bare = folder / "bare.toml"
    bare.write_text(MACHINE_FILE.read_text(encoding="utf-8"), encoding="utf-8")
    with one_at_a_time(OUT):
        builder = Builder(
            extended_file(bare, diagnosis(stiffness(K_3)), folder / "stiff.toml"), folder
        )
        builder.systems()
    return builder


@pytest.fixture(scope="module")
def log(stiff: Builder) -> Path:
    """A run of that machine, as a file."""
    case = extra_cases(stiff.machine, base_parameters(stiff.machine), SECONDS)[1]
    result = run(stiff.case(case), case.duration, signals=("plant.theta", "plant.tau_meas"))
    path = stiff.out / "stiff.h5"
    with h5py.File(path, "w") as file:
        file["time"] = result.time("plant.theta")
        file["time"].attrs["unit"] = "s"
        for name, unit in (("theta", "rad"), ("tau_meas", "N m")):
            file[name] = result[f"plant.{name}"]
            file[name].attrs["unit"] = unit
    return path


@pytest.fixture(scope="module")
def rebuilt(log: Path) -> Rebuilt:
    """What is made of the right effect and a wrong one."""
    folder = OUT / "rebuild" / "rebuilt"
    given = diagnosis(stiffness(K_3), tilt(0.02))
    bare = OUT / "rebuild" / "bare.toml"
    with one_at_a_time(OUT):
        return rebuild(bare, given, folder, held_out=[log], seconds=3.0)


def residual(builder: Builder, log: Log) -> Array:
    machine = builder.machine
    replayed = replay(builder.out / "fmus", machine, base_parameters(machine), log)
    assert replayed.followed < 1e-4, "the simulation must stay at the log's angles"
    return replayed.rms


def test_replay_of_the_right_model_leaves_no_residual(stiff: Builder, log: Path) -> None:
    # torque in steps of 3 mN m at 4 kHz, its mean over a tick taken by the trapezoid: measured 0.2
    assert (residual(stiff, read_log(log)) < 5e-4).all()


def test_replay_of_a_model_that_lacks_an_effect_shows_its_torque(
    builder: Builder, log: Path
) -> None:
    measured = read_log(log)
    theta = measured.theta[:, AXIS - 1]
    judged = np.arange(len(theta)) * measured.ts > 1.5
    wanted = float(np.sqrt(((K_3 * theta**3)[judged] ** 2).mean()))
    result = residual(builder, measured)
    # the feedback sees the torque through its bandwidth: a tenth is lost or turned
    assert result[AXIS - 1] == pytest.approx(wanted, rel=0.1)
    assert result[AXIS - 1] > 10 * np.delete(result, AXIS - 1).max()


def test_replay_begins_where_the_log_begins(stiff: Builder, log: Path) -> None:
    whole = read_log(log)
    first = int(2.6 / whole.ts)
    part = Log.of("part", whole.ts, whole.theta[first:], whole.tau[first:])
    assert np.abs(part.theta[0]).max() > 0.01, "the case must be an approach"
    # the hysteresis has another past, which fades: hence more than from the start
    assert (residual(stiff, part) < 5e-3).all()


def test_plant_values_move_like_the_machine_file(builder: Builder, log: Path) -> None:
    machine = builder.machine
    values = plant_values(machine, base_parameters(machine))
    plain = np.array(nominal_mechanism(machine).vector(), dtype=float).ravel()
    # p regroups masses and inertias, and its lower arms have J_yy < 0: plant.fmu refuses them
    assert np.abs(values["mechanism"] - plain).max() < 1e-12
    p = base_parameters(machine) * np.random.default_rng(5).uniform(0.9, 1.1, 162)
    full = Mechanism.split(ca.DM(plant_values(machine, p)["mechanism"]), machine.n_arms)
    assert np.abs(regrouped(machine, full) - p[-30:]).max() < 1e-12, "it moves like p"
    assert set(values) == {"mechanism", "actuator"}
    assert set(plant_values(load_machine(OUT / "rebuild" / "stiff.toml"), np.ones(163))) == {
        "mechanism",
        "actuator",
        "effect",
    }


@pytest.mark.slow
def test_rebuild_withdraws_what_makes_a_held_out_run_worse(rebuilt: Rebuilt) -> None:
    assert rebuilt.withdrawn == ("gravity_tilt",)
    uses = load_machine(rebuilt.machine_file).effects
    assert [use.id for use in uses] == ["cubic_stiffness"]
    (residuals,) = rebuilt.residuals.values()
    assert residuals.after[AXIS - 1] < 0.1 * residuals.before[AXIS - 1]


def test_model_that_no_fit_was_possible_for_is_judged_beside_one_without_a_fit(
    log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit takes up most of what the old model lacks; the extended one must not lose by that."""

    def only_old(machine: Machine, logs: object, notes: list[str]) -> Fit | None:
        p = base_parameters(machine)
        if machine.effects or not logs:
            return None
        p[4 + 2 * machine.actuator.n_harmonics + 1] += 0.1  # k[2]
        nothing = np.zeros(0)
        return Fit(p, 0.1 * np.ones_like(p), nothing, 1.0, 0, ())

    monkeypatch.setattr("flexhex.diagnose.rebuild._fit", only_old)
    bare, folder = OUT / "rebuild" / "bare.toml", OUT / "rebuild" / "unfitted"
    with one_at_a_time(OUT):
        unfitted = rebuild(bare, diagnosis(stiffness(K_3)), folder, [log], [log], loops=False)
        plain = rebuild(bare, diagnosis(stiffness(K_3)), folder, [], [log], loops=False)
    (residuals,), (expected,) = unfitted.residuals.values(), plain.residuals.values()
    assert np.array_equal(residuals.before, expected.before)
    assert np.array_equal(residuals.after, expected.after)


@pytest.mark.slow
def test_rebuild_predicts_the_loop(rebuilt: Rebuilt) -> None:
    before, after = rebuilt.loops["model"]
    # an exact plant under its own model: 1 urad and below 3; without the effect several times that
    assert after.e < 3.0
    assert before.e > 2 * after.e
    assert before.tau_fb > 2 * after.tau_fb
    assert "machine" not in rebuilt.loops, "there is no truth file"
    assert rebuilt.data()["closed_loop"]["model"]["after"]["e"] == after.e
