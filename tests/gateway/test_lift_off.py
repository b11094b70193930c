"""Lift-off, run and landing against the simulation of the same schedule, bit by bit."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from flexhex.ssp.read import read_ssp
from tests.gateway.bench import Bench, Rows, never_enabled
from tests.gateway.landing_twin import BRAKE, MOST, PAUSE, SPEED, Braked, Model, smooth
from tests.gateway.replay import replayed
from tests.gateway.slave import Slave
from tests.gateway.test_lockstep import STEPS, same
from tests.gateway.weight import REST_S, TS, Fallen, free

SECONDS = 3.0


@pytest.fixture(scope="module")
def fallen(hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory) -> Fallen:
    """Three seconds with lift-off and landing, drives that coast."""
    return free(Bench(hexapod_ssp, tmp_path_factory.mktemp("lift")), braking=0.0, seconds=SECONDS)


def test_good_run_lifts_off_and_lands(fallen: Fallen) -> None:
    assert fallen.ran.code == 0, fallen.ran.words
    assert "done, drives disabled" in fallen.ran.words
    fallen.ends_at_rest(0)
    start, end = fallen.theta[0], fallen.theta[-1]
    assert start.max() < -0.3, "it rests on its weight"
    assert np.abs(end - start).max() < 0.02, "it ends where it began"
    # nothing falls when the power is taken: the drives carried nothing any more
    off = np.flatnonzero(np.abs(fallen.tau).max(axis=1) > 0)[-1]
    assert np.abs(fallen.tau[off]).max() < 0.3
    assert fallen.speed[off:].max() < 0.2
    # the run itself begins at the start of the reference
    running = fallen.ran.table["phase"] == 1
    assert np.abs(fallen.ran.table["theta"][running][0]).max() < 1e-3


def test_machine_sinks_a_little_until_the_controller_carries_it(fallen: Fallen) -> None:
    """Figures of docs/gateway-stops.md: the first outputs of FMUs are zero, in simulations too."""
    begin = int(fallen.ran.one("summary")["lifted"]) + 1
    tau, theta = fallen.tau[begin:], fallen.theta[begin:]
    assert not tau[:4].any()
    assert np.abs(tau[4]).max() < 0.01, "the feedback alone"
    assert np.abs(tau[5]).min() > 0.5
    sunk = theta[0] - theta[:2000]  # half a second
    assert sunk.max() * 1e3 == pytest.approx(0.41, abs=0.005)
    assert np.diff(sunk, axis=0).max() / TS * 1e3 == pytest.approx(17.0, abs=0.5)
    assert sunk[-1].max() < 0.0, "it has risen again"


LAND = ("torque_N_m = 6.0 ", "torque_N_m = {} ")
"""Largest torque of lift-off and landing."""


def test_torque_that_does_not_lift_the_machine_is_refused_before_power(
    fallen: Fallen, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """It tripped in the lift-off. The rest pose is not known here: the model says it, too."""
    bench = Bench(hexapod_ssp, tmp_path)
    lifted = int(fallen.ran.one("summary")["lifted"])
    measured = np.abs(fallen.tau[:lifted]).max(axis=0)
    needed = 0.0
    for command in (
        ("check",),
        ("run", "--enable", "--lockstep"),
        ("move", "--lockstep", "--enable"),
    ):
        ran = bench.run(command=command, changes=((LAND[0], LAND[1].format(0.8)),))
        assert ran.code == 3, ran.words
        never_enabled(ran)
        message = str(ran.one("refused")["message"])
        told = re.search(r"axis (\d) needs ([\d.]+) N m to carry the machine, allowed 0.8", message)
        assert told, message
        assert int(told[1]) == int(measured.argmax()) + 1
        needed = float(told[2])
        # the torques of the run are those of the model and what the feedback adds
        assert measured.max() / 1.05 < needed < measured.max()
    enough = ((LAND[0], LAND[1].format(needed + 0.01)),)
    assert free(bench, braking=0.0, seconds=0.1, changes=enough).ran.code == 0


class Plant(Slave):
    """plant.fmu, with the steps of the drives."""

    def __init__(self, fmu: Path, folder: Path) -> None:
        quantised = {"tau_step": STEPS["akd"], "theta_step": 2 * np.pi / 2**32}
        super().__init__(fmu, folder, "plant", quantised)
        self.steps = 0

    def step(self, tau: Rows) -> None:
        """One base step."""
        self.set({f"tau[{k}]": value for k, value in enumerate(tau, start=1)})
        self.fmu.doStep(self.steps * TS, TS)
        self.steps += 1

    def theta(self) -> Rows:
        """Encoder readings."""
        return np.array(self.get([f"theta[{k}]" for k in range(1, 7)]))


def test_machine_from_power_up_is_the_simulated_one(
    fallen: Fallen, fmu_dir: Path, tmp_path: Path
) -> None:
    """plant.fmu alone: first without torque, then under the torques that the gateway sent."""
    plant = Plant(fmu_dir / "plant.fmu", tmp_path)
    frames = next(e["frame"] for e in fallen.ran.drives if e["event"] == "enabled")
    for _ in range(round(REST_S / TS) + frames):
        plant.step(np.zeros(6))
    theirs = []
    for tau in fallen.tau:
        theirs.append(plant.theta())
        plant.step(tau)
    assert same(fallen.theta + 0.0, np.array(theirs) + 0.0)


class Pid:
    """The gateway's moves, anew: a path, six PIDs as in feedback.fmu, a line for the weight."""

    def __init__(self, ssp: Path, rest: Rows) -> None:
        instance = read_ssp(ssp).instance("feedback")
        value = instance.parameters | {
            name: v.start for name, v in instance.fmu.variables.items() if v.start is not None
        }
        named = {**value, **instance.parameters}
        self.kp = np.array([float(named[f"kp[{k}]"]) for k in range(1, 7)])
        self.t_i, self.t_d, self.t_f = (float(named[k]) for k in ("t_i", "t_d", "t_f"))
        self.weight = np.array([float(named[f"tau_ff[{k}]"]) for k in range(1, 7)])
        self.rest, self.sum, self.rate, self.last = rest, np.zeros(6), np.zeros(6), None

    def begin_with(self, more: Rows) -> None:
        """The first torque beyond what holds, where the errors are zero."""
        self.sum = more * self.t_i / self.kp

    def holding(self, r: Rows) -> Rows:
        """The line of the weight."""
        return np.asarray(self.weight * np.clip(1.0 - r / self.rest, 0.0, 2.0))

    def torque(self, r: Rows, theta: Rows, model: Rows | None = None) -> Rows:
        """Torque of the next frame, in whole steps of the drive; model: in the line's place."""
        e = r - theta
        last = e if self.last is None else self.last
        self.sum = self.sum + TS / 2.0 * (last + e)
        slope, lag = 2.0 * self.t_f - TS, 2.0 * self.t_f + TS
        self.rate = (slope * self.rate + 2.0 * (e - last)) / lag
        self.last = e
        hold = self.holding(r) if model is None else model
        tau = hold + self.kp * (e + self.sum / self.t_i + self.t_d * self.rate)
        assert np.abs(tau).max() < MOST
        return np.round(tau / STEPS["akd"]) * STEPS["akd"]


def test_lift_off_is_the_planned_one_to_the_last_bit(fallen: Fallen, hexapod_ssp: Path) -> None:
    theta, rest = fallen.theta, fallen.theta[0]
    pid = Pid(hexapod_ssp, rest)
    travel = int(np.ceil(1.875 * np.abs(rest).max() / SPEED / TS))
    cycles = travel + round(PAUSE / TS)
    wanted = []
    for k in range(cycles):
        share = smooth(k / travel) if k < travel else 1.0
        r = rest + (0.0 - rest) * share if k < travel else np.zeros(6)
        wanted.append(pid.torque(r, theta[k]))
    # the torque from a cycle's angles acts in the next; after the last the controller begins
    assert same(fallen.tau[1:cycles] + 0.0, np.array(wanted[:-1]) + 0.0)


def test_landing_is_the_planned_one_to_the_last_bit(
    fallen: Fallen, hexapod_ssp: Path, fmu_dir: Path, tmp_path: Path
) -> None:
    """The torques of the planned motion by FMPy, and a PID anew."""
    theta, rest = fallen.theta, fallen.theta[0]
    running = fallen.ran.table["phase"] == 1
    travel = int(np.ceil(1.875 * np.abs(rest).max() / SPEED / TS))
    end = travel + round(PAUSE / TS) + int(np.count_nonzero(running)) - 1
    path = Braked(theta[end], (theta[end] - theta[end - 8]) / (8.0 * TS), rest)
    pid, model = Pid(hexapod_ssp, rest), Model(fmu_dir, tmp_path)
    # what the drives gave on average in the time of braking, and where
    given, mean = np.zeros(6), theta[0].copy()
    for k in range(end + 1):
        mean += TS / BRAKE * (theta[k] - mean)
    for tau in fallen.ran.table["tau_meas"][fallen.ran.table["phase"] != 4][: end + 1]:
        given = given + TS / BRAKE * (tau - given)
    rate = (path.start - mean) / BRAKE
    rates = rate, (path.rate - rate) / BRAKE
    model.torque(2.0 * mean - path.start, *rates)
    pid.begin_with(given - model.torque(mean, *rates))
    wanted = []
    model.torque(*path.motion(0))
    for k in range(path.cycles):
        expected = model.torque(*path.motion(k)) if k else model.tau
        wanted.append(pid.torque(path.at(k), theta[end + k], expected))
    assert same(fallen.tau[end + 1 : end + path.cycles] + 0.0, np.array(wanted[:-1]) + 0.0)


CONTROLLED = {
    "r": "reference.r",
    "tau": "feedback.tau",
    "tau_ff": "F.tau_ff",
    "e": "feedback.e",
}


def test_torques_of_the_fmus_after_a_lift_off_are_the_simulated_ones(
    fallen: Fallen, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Every cycle between lift-off and landing, by the FMUs alone on the angles that they had."""
    table = fallen.ran.table
    running = table["phase"] == 1
    assert np.count_nonzero(running) == round(SECONDS / TS)
    theta, tau_meas = table["theta"][running], table["tau_meas"][running]
    steps = {"feedback": {"tau_step": STEPS["akd"]}}
    theirs: dict[str, list[list[float]]] = {name: [] for name in CONTROLLED}
    for bus in replayed(hexapod_ssp, tmp_path, steps, theta, tau_meas):
        for name, signal in CONTROLLED.items():
            theirs[name].append([bus[f"{signal}[{k}]"] for k in range(1, 7)])
    for name in CONTROLLED:
        assert same(table[name][running] + 0.0, np.array(theirs[name]) + 0.0), name
    assert np.ptp(table["tau"][running], axis=0).min() > 0.1, "the torques change"
