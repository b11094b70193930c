"""Simulation of held-out runs from their torques: what it says of models that are right or not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.forward.record import Simulation
from flexhex.diagnosis.estimation.found import read_diagnosis
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from flexhex.init import two_links as example
from tests.diagnosis import two_links
from tests.diagnosis.estimation import machines, test_extras
from tests.diagnosis.estimation.test_identified import arm

Array = NDArray[np.float64]
WHEEL = """
import numpy as np

class Wheel:
    axes = ("rotary",)
    parameters = (("wheel.J", "kg m2", 0.05, 1e-4), ("wheel.weight", "N m", 2.0, 0.004))

    def columns(self, theta, thetad, thetadd):
        return np.stack([thetadd, np.sin(theta)], axis=2)
"""
OWN = f"{example.__file__}:TwoLinks"


def told(identified: Identified) -> Simulation:
    assert identified.simulation is not None
    return identified.simulation


@pytest.fixture(scope="module")
def links(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Path], Simulation]:
    paths = arm(tmp_path_factory.mktemp("links"), (1, 2, 3))
    return paths, told(identify(paths[:2], paths[2:], options=Options(OWN)))


def test_estimates_leave_a_part_of_what_a_constant_rate_does(
    links: tuple[list[Path], Simulation],
) -> None:
    _, own = links
    assert own.held_out
    assert own.units == ("rad", "rad")
    assert own.horizons == (0.05, 0.2, 1.0)
    assert (own.at(own.fitted) < 0.15 * own.at(own.constant)).all()
    # friction that the file has not makes it worth little
    assert own.file is not None
    assert (own.at(own.fitted)[:2] < 0.05 * own.at(own.file)[:2]).all()
    assert own.file.diverged > 0
    assert own.fitted.diverged == 0


def test_errors_of_a_constant_rate_are_those_of_the_motion(
    links: tuple[list[Path], Simulation],
) -> None:
    """By the motion that the log was made of, from its own starts."""
    paths, own = links
    t = np.loadtxt(paths[2], delimiter=",", skiprows=3)[:, 0]
    q, v, _ = two_links.moved(t, 3)
    after = round(0.2 / (t[1] - t[0]))
    off = q[after:] - q[:-after] - 0.2 * v[:-after]
    known = np.sqrt((off[::100] ** 2).mean(axis=0))
    # 40 windows of the run stand for all of it
    np.testing.assert_allclose(own.at(own.constant)[1], known, rtol=0.25)


def test_measured_windows_of_a_run_are_its_angles(
    links: tuple[list[Path], Simulation],
) -> None:
    paths, own = links
    assert own.run == str(paths[2])
    rows = np.loadtxt(paths[2], delimiter=",", skiprows=3)
    there = np.isfinite(own.time)
    for i in range(2):
        known = np.interp(own.time[there], rows[:, 0], rows[:, 1 + i])
        # smoothed over 32 ms: sums of sines of up to 9 rad/s
        assert np.abs(own.measured[there, i] - known).max() < 0.01
    gaps = np.flatnonzero(~there)
    assert len(gaps) >= 5
    assert np.isnan(own.fitted.line[gaps]).all()


def test_data_has_null_where_a_window_diverged(links: tuple[list[Path], Simulation]) -> None:
    _, own = links
    data = own.data()
    assert data["position_error_rms"]["file"][2] == [None, None]
    assert set(data["diverged"]) == {"file"}
    assert 0.05 < data["diverged"]["file"]["first"] < 1.0
    assert data["windows"] == own.windows > 20


def test_torques_that_are_late_are_read_at_their_time(tmp_path: Path) -> None:
    """The same runs with torques 4 ms late: the fit knows it, and so does the simulation."""
    (tmp_path / "late").mkdir()
    paths = []
    for path in arm(tmp_path, (1, 2, 3)):
        head, *rows = path.read_text().split("s,rad,rad,N m,N m\n")
        values = np.loadtxt(rows[0].splitlines(), delimiter=",")
        values = np.column_stack([values[2:, :3], values[:-2, 3:]])
        paths.append(tmp_path / "late" / path.name)
        with paths[-1].open("w") as file:
            file.write(f"{head}s,rad,rad,N m,N m\n")
            np.savetxt(file, values, delimiter=",", fmt="%.9g")
    identified = identify(paths[:2], paths[2:], options=Options(OWN))
    assert identified.delay.value == pytest.approx(0.004, abs=2e-4)
    own = told(identified)
    assert (own.at(own.fitted)[:2] < 0.05 * own.at(own.constant)[:2]).all()


def test_arm_of_mujoco_is_simulated_to_a_thousandth(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    file = tmp_path / "cart.xml"
    file.write_text(machines.CART)
    paths = machines.cart_runs(tmp_path, machines.heavier(machines.CART), (1, 2, 3))
    own = told(identify(paths[:2], paths[2:], options=Options(str(file))))
    assert own.units == ("m", "rad", "rad")
    # noise of the measured rate is most of it at first
    limits = np.array([[6e-3], [3e-3], [1e-3]])
    assert (own.at(own.fitted) < limits * own.at(own.constant)).all()


def test_found_effects_are_simulated_with_their_states(tmp_path: Path) -> None:
    """Friction that falls with the rate and remembers its way, and cogging."""
    paths, found = test_extras.logs(tmp_path), test_extras.written(tmp_path, test_extras.FOUND)
    plain = told(identify(paths[:1], paths[1:], options=Options("axis")))
    more = read_diagnosis(found)
    own = told(identify(paths[:1], paths[1:], options=Options("axis"), more=more))
    assert own.left_out == ()
    assert (own.at(own.fitted)[:2] < 0.3 * own.at(plain.fitted)[:2]).all()
    assert (own.at(own.fitted)[:2] < 0.05 * own.at(own.constant)[:2]).all()


def rubbing(v: Array, tau: Array) -> Array:
    """0.2 |tau| against the rate, relative to tau."""
    return 0.2 * np.sign(v) * np.sign(tau)


def warming(v: Array, tau: Array) -> Array:
    """The loss of a motor whose mean square torque is remembered for 4 s."""
    w, kept = np.zeros_like(tau), np.exp(-2e-3 / 4.0)
    for k in range(1, len(tau)):
        w[k] = kept * w[k - 1] + (1 - kept) * tau[k] ** 2
    return 0.03 * w


DRIVEN: dict[str, tuple[Callable[[Array, Array], Array], dict[str, float]]] = {
    "load_friction": (rubbing, {"mu": 0.2, "s_0": 1e-4}),
    "thermal_drift": (warming, {"g_t": 0.0, "g_w": 0.03, "T": 4.0}),
}


@pytest.mark.parametrize("name", DRIVEN)
def test_effect_that_goes_with_the_reported_torque_is_simulated(name: str, tmp_path: Path) -> None:
    """A weight that a wheel of 0.05 kg m2 turns about; a part of the torque never gets there."""
    lost, found = DRIVEN[name]
    t, paths = 2e-3 * np.arange(6000), []
    for seed in (1, 2):
        q, v, a = machines.moved(t, seed, (1.5,))
        needed = 0.05 * a + 2.0 * np.sin(q)
        tau = needed
        for _ in range(30):
            tau = needed / (1 - lost(v, tau))
        path = tmp_path / f"{seed}.csv"
        paths.append(machines.write(path, t, q, tau, (False,), "", seed))
    values = {key: {"value": value} for key, value in found.items()}
    more = read_diagnosis(found_effect(tmp_path, name, values))
    plain = told(identify(paths[:1], paths[1:], options=Options("axis")))
    own = told(identify(paths[:1], paths[1:], options=Options("axis"), more=more))
    assert own.left_out == ()
    assert (own.at(own.fitted) < 0.2 * own.at(plain.fitted)).all()
    assert (own.at(own.fitted) < 0.05 * own.at(own.constant)).all()


def test_effect_sees_the_torque_before_its_drive_loses_any(tmp_path: Path) -> None:
    """Load friction of 0.2 of a motor that is said to lose a quarter, and does."""
    t, paths = 2e-3 * np.arange(6000), []
    for seed in (1, 2):
        q, v, a = machines.moved(t, seed, (1.5,))
        needed = 0.05 * a + 2.0 * np.sin(q)
        tau = needed / (0.75 - rubbing(v, needed))
        paths.append(machines.write(tmp_path / f"{seed}.csv", t, q, tau, (False,), "", seed))
    base = tmp_path / "wheel.py"
    base.write_text(WHEEL)
    effects = [
        {"id": name, "axes": [1], "rivals": [], "parameters": values}
        for name, values in (
            ("load_friction", {"mu": {"value": 0.2}, "s_0": {"value": 1e-4}}),
            ("drive_gain", {"g": {"value": 0.25}}),
        )
    ]
    more = read_diagnosis(test_extras.written(tmp_path, {"verdict": "named", "effects": effects}))
    own = told(identify(paths[:1], paths[1:], options=Options(f"{base}:Wheel"), more=more))
    assert (own.at(own.fitted) < 0.05 * own.at(own.constant)).all()


def test_effect_that_is_no_function_of_the_state_is_named(tmp_path: Path) -> None:
    mode = {"J_2": {"value": 1e-3}, "f": {"value": 20.0}, "zeta": {"value": 0.05}}
    paths, file = test_extras.logs(tmp_path), found_effect(tmp_path, "flexible_mode", mode)
    own = told(identify(paths[:1], paths[1:], options=Options("axis"), more=read_diagnosis(file)))
    assert own.left_out == ("flexible_mode of axis 1",)


def found_effect(folder: Path, name: str, parameters: dict[str, object]) -> Path:
    effect = {"id": name, "axes": [1], "rivals": [], "parameters": parameters}
    return test_extras.written(folder, {"verdict": "named", "effects": [effect]})


def test_base_without_a_file_has_no_such_column(tmp_path: Path) -> None:
    paths = arm(tmp_path, (1, 2))
    own = told(identify(paths, options=Options("axis")))
    assert own.file is None
    assert not own.why
    assert not own.held_out
    assert set(own.data()["position_error_rms"]) == {"constant_rate", "fitted"}


def test_friction_remembers_the_way_of_the_run_before_a_window(tmp_path: Path) -> None:
    """Forgotten, it would begin each window with friction that is not up yet."""
    inertia, dry, way, t = 0.05, 2.0, 0.02, 2e-3 * np.arange(6000)
    paths = []
    for seed in (1, 2):
        q, _, a = machines.moved(t, seed, (0.6,))
        z = np.zeros(len(t))
        for k, step in enumerate(np.diff(q[:, 0]), start=1):
            left = np.exp(-abs(step) / way)
            z[k] = left * z[k - 1] + np.sign(step) * (1 - left)
        tau = inertia * a + dry * z[:, None]
        path = tmp_path / f"{seed}.csv"
        paths.append(machines.write(path, t, q, tau, (False,), "", seed))
    identified = identify(paths[:1], paths[1:], options=Options("axis"))
    assert identified.estimated.forms[0].kind == "way"
    own = told(identified)
    assert (own.at(own.fitted) < 0.02 * own.at(own.constant)).all()
