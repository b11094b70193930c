"""Errors of a hexapod's geometry: columns against machine files that have them, and MuJoCo's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.hexapod import HexapodBase
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, machine_data
from flexhex.fmus.common.model.bodies import Mechanism
from flexhex.fmus.common.model.dynamics import loads, project
from flexhex.fmus.common.model.model import Model
from studies.mujoco import hexapod
from studies.mujoco.draw import draw
from studies.mujoco.model import compiled, inverse
from studies.mujoco.runs import runs_of
from tests.compare import assert_close

Array = NDArray[np.float64]
Data = dict[str, Any]
MACHINE = Path("machines/tflex.toml")
ARM, OTHER = 1, 4
"""An arm whose errors are looked at, and one beside it, from 0."""
STEP, NEWTON_STEPS, SAMPLES = 1e-5, 10, 3
AXES = np.eye(3)


def upper_axes(data: Data, arm: int) -> Array:
    """Axes of an upper arm at neutral: along it, motor axis, across."""
    u, axis = (np.array(data["arms"][arm][name]["value"]) for name in ("u_B", "axis"))
    return np.column_stack([u, axis, np.cross(u, axis)])


def add(table: Data, name: str, more: Array) -> None:
    table[name]["value"] = (np.array(table[name]["value"]) + more).tolist()


def placed(data: Data, k: int, by: float) -> None:
    """Motor and spherical joint of an arm moved alike: the lower arm stays."""
    for name in ("x_B", "r_EP"):
        add(data["arms"][ARM], name, by * upper_axes(data, ARM)[:, k])


def turned(data: Data, k: int, by: float) -> None:
    """Motor and upper arm turned about the tip of the upper arm."""
    arm, B = data["arms"][ARM], upper_axes(data, ARM)
    c, s, (i, j) = np.cos(by), np.sin(by), [(1, 2), (2, 0), (0, 1)][k]
    R = np.eye(3)
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    after = B @ R
    add(arm, "x_B", data["geometry"]["L"]["value"] * (B - after)[:, 0])
    arm["u_B"]["value"], arm["axis"]["value"] = after[:, 0].tolist(), after[:, 1].tolist()


def longer_cranks(data: Data, k: int, by: float) -> None:
    """All upper arms longer, their motors as much behind."""
    data["geometry"]["L"]["value"] += by
    for i in range(6):
        add(data["arms"][i], "x_B", -by * upper_axes(data, i)[:, 0])


def longer_rods(data: Data, k: int, by: float) -> None:
    """All lower arms longer, their joints on the end-effector as much beyond."""
    rods = hexapod_rods(data)
    data["geometry"]["l"]["value"] += by
    for i in range(6):
        add(data["arms"][i], "r_EP", by * rods[i])


def hexapod_rods(data: Data) -> Array:
    """Unit vectors (6, 3) along the lower arms at neutral."""
    geometry = data["geometry"]
    x_E0, L = np.array(geometry["x_E0"]["value"]), geometry["L"]["value"]
    x_B, u_B, r_EP = (
        np.array([arm[name]["value"] for arm in data["arms"]]) for name in ("x_B", "u_B", "r_EP")
    )
    rods = x_E0 + r_EP - x_B - L * u_B
    return np.asarray(rods / np.linalg.norm(rods, axis=1)[:, None])


def expected(change: Callable[[Data, int, float], None], k: int) -> dict[str, float]:
    """The errors that a change of the file makes, for a unit of it."""
    data = machine_data(MACHINE)
    own, L = f"arm[{ARM + 1}]", data["geometry"]["L"]["value"]
    if change is placed:
        move = upper_axes(data, ARM)[:, k]
        on_E = {f"{own}.P_{x}": v for x, v in zip("xyz", move, strict=True)}
        return {f"{own}.{'xyz'[k]}": 1.0, **on_E}
    if change is turned:
        back = -L * np.cross(AXES[k], AXES[0])
        moves = {f"{own}.{x}": v for x, v in zip("xyz", back, strict=True)}
        return {f"{own}.{('roll', 'pitch', 'yaw')[k]}": 1.0, **moves}
    names = dict[str, float]()
    for i, rod in enumerate(hexapod_rods(data)):
        if change is longer_cranks:
            names |= {f"arm[{i + 1}].L": 1.0, f"arm[{i + 1}].x": -1.0}
        else:
            on_E = {f"arm[{i + 1}].P_{x}": v for x, v in zip("xyz", rod, strict=True)}
            names |= {f"arm[{i + 1}].l": 1.0, **on_E}
    return names


@cache
def base() -> HexapodBase:
    return HexapodBase(load_machine(MACHINE))


def motion() -> Motion:
    rng = np.random.default_rng(2)
    theta = rng.uniform(-0.19, 0.19, (SAMPLES, 6))
    return Motion(0.0, 0.005, theta, *rng.normal(size=(2, SAMPLES, 6)))


def parameters() -> Array:
    """Rods that are alike all round and joints without stiffness: where a rod's own turn is zero,
    which a file defines anew for other motors, makes no torque then."""
    p = np.array([known.nominal for known in base().linear])
    for j, known in enumerate(base().linear):
        body, _, entry = known.name.partition(".")
        thin = entry in ("mc_y", "mc_z", "J_xx", "J_xy", "J_xz", "J_yz")
        if body.startswith("flexure") or (body.startswith("lower") and thin):
            p[j] = 0.0
        if entry == "J_zz" and body.startswith("lower"):
            p[j] = p[j - 1]
    return p


def torque(machine: Machine) -> Array:
    """Torques (samples, 6) of the mechanism of a machine along `motion`."""
    model, par = Model(machine), parameters()[len(base()._kept) :]
    X, thetad, thetadd = ca.SX.sym("x", model.n_x), ca.SX.sym("v", 6), ca.SX.sym("a", 6)
    linkage = model.linkage(X)
    step = ca.Function("step", [X], [ca.vertcat(X[:6], linkage.newton())])
    xd = linkage.rates(thetad)
    load = loads(
        linkage,
        model.motion(xd, linkage.accelerations(xd, thetadd)),
        Mechanism.split(ca.SX(par), 6),
    )
    tau, moved, outputs = (
        ca.Function("tau", [X, thetad, thetadd], [project(linkage, load)]),
        motion(),
        [],
    )
    for k in range(SAMPLES):
        x = np.concatenate([moved.theta[k], model.frames.x0[6:]])
        for _ in range(NEWTON_STEPS):
            x = np.array(step(x)).ravel()
        outputs.append(np.array(tau(x, moved.thetad[k], moved.thetadd[k])).ravel())
    return np.array(outputs)


CHANGES = [(placed, 0), (placed, 1), (placed, 2), (turned, 0), (turned, 1), (turned, 2)]
CHANGES += [(longer_cranks, 0), (longer_rods, 0)]


@pytest.mark.parametrize(("change", "k"), CHANGES)
def test_columns_are_the_differences_of_a_changed_machine_file(
    change: Callable[[Data, int, float], None], k: int
) -> None:
    ends = []
    for by in (STEP, -STEP):
        data = machine_data(MACHINE)
        change(data, k, by)
        ends.append(torque(Machine.model_validate(data)))
    wanted = (ends[0] - ends[1]) / (2 * STEP)
    geometry = base().geometry
    assert geometry is not None
    columns = geometry.columns(motion(), csr_array(eye_array(SAMPLES)), parameters())
    at = [known.name for known in geometry.known]
    total = sum(size * columns[:, :, at.index(name)] for name, size in expected(change, k).items())
    # differences of torques of some N m, divided by 2e-5
    assert_close(np.asarray(total), wanted, atol=1e-6 * np.abs(wanted).max())


def test_a_row_without_samples_has_no_columns() -> None:
    geometry = base().geometry
    assert geometry is not None
    whole, holed = np.eye(SAMPLES), np.diag([1.0, 0.0, 1.0])
    wanted, actual = (
        geometry.columns(motion(), csr_array(weights), parameters()) for weights in (whole, holed)
    )
    assert (actual[1] == 0.0).all()
    assert (actual[[0, 2]] == wanted[[0, 2]]).all()


def assembled(nominal: hexapod.Hexapod, size: float) -> hexapod.Hexapod:
    """A hexapod whose joints are `size` of a crank off; its lower arms are as long as they must."""
    rng = np.random.default_rng(3)

    def off(values: Array, scale: float) -> Array:
        return np.asarray(values + scale * size * rng.standard_normal(values.shape))

    axis = off(nominal.axis, 1.0)
    u_B = off(nominal.u_B, 1.0)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    u_B -= (u_B * axis).sum(axis=1)[:, None] * axis
    u_B /= np.linalg.norm(u_B, axis=1)[:, None]
    x_B, r_EP = off(nominal.x_B, nominal.L), off(nominal.r_EP, nominal.L)
    return replace(nominal, x_B=x_B, r_EP=r_EP, axis=axis, u_B=u_B)


def test_hexapod_whose_geometry_is_wrong_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("studies.mujoco.draw.MOST_STEPS", 6000)
    case = draw(5, "nothing", "hexapod")
    nominal = case.machine.chain
    file = tmp_path / "machine.toml"
    file.write_text(hexapod.toml(nominal, max(case.machine.reach), 0.015, 0.005))
    real = replace(case.machine, chain=assembled(nominal, 0.005))
    quiet = replace(case.noise, disturbance=0.0)
    case = replace(case, machine=real, noise=quiet, passes=1, trajectories=case.trajectories[:2])
    model, runs = compiled(real, case.step, ()), list[Run]()
    for number, (record,) in enumerate(runs_of(case).records):
        at, ts = record.at, float(record.t[1] - record.t[0])
        moved = Motion(0.0, ts, *(values[:, at] for values in (record.q, record.v, record.a)))
        valid = np.ones(len(record.t), dtype=bool)
        tau = inverse(model, record.q, record.v, record.a)[:, at]
        for again in "ab":
            noise = np.random.default_rng(len(runs)).standard_normal(tau.shape)
            signal = TimeSeries(0.0, ts, tau + 1e-4 * tau.std(axis=0) * noise, valid)
            runs.append(Run(f"{number}{again}", str(number), moved, valid, signal))
    knows = HexapodBase(load_machine(file))
    knows.settle = 0.0
    left = []
    for geometry in (knows.geometry, None):
        knows.geometry = geometry
        corrected = calibrate(knows, blocks(knows, runs, knows.spacing))
        rest = corrected.residual(corrected.regression.q)
        left.append(axis_rms(corrected.blocks, rest) / corrected.torque_rms)
    # noise is 1e-4, MuJoCo's connections give a little; a firm geometry leaves four times as much
    assert left[0].max() < 4e-4
    assert left[1].max() > 1e-3
