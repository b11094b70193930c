"""The FMU of an identified machine: its torque is that of Pinocchio, NumPy and the machine."""

from __future__ import annotations

import re
from pathlib import Path

import fmpy
import numpy as np
import pinocchio as pin
import pytest
from fmpy import simulate_fmu
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.basemodels.columns import ColumnBase
from flexhex.diagnosis.basemodels.symbolic import symbolic_torque
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.kinds import ROTARY
from flexhex.diagnosis.prepare import Options
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.identify.inverse import write_fmu
from flexhex.init import two_links as example
from tests.compare import assert_close
from tests.diagnosis.estimation import machines

Array = NDArray[np.float64]
TS = machines.TS
TEN = ["m", "mc_x", "mc_y", "mc_z", "J_xx", "J_xy", "J_yy", "J_xz", "J_yz", "J_zz"]


def played(
    file: Path, q: Array, v: Array, a: Array, start: dict[str, float] | None = None
) -> Array:
    """Torques (samples - 2, n) by FMPy for all but the first and the last row of a motion
    (samples, n): the FMU reads inputs from the first Ts on, and shows the torque one Ts later."""
    n, t = q.shape[1], np.arange(len(q)) * TS
    names = [f"{name}[{i + 1}]" for name in ("r", "rd", "rdd") for i in range(n)]
    given = np.zeros(len(t), dtype=[("time", float), *((name, float) for name in names)])
    given["time"] = t
    for name, values in zip(names, np.hstack([q, v, a]).T, strict=True):
        given[name] = values
    rows = simulate_fmu(
        str(file), stop_time=t[-1], step_size=TS, output_interval=TS, input=given,
        output=["fault", *(f"tau_ff[{i + 1}]" for i in range(n))], start_values=start or {},
    )  # fmt: skip
    assert not rows["fault"].any()
    return np.column_stack([rows[f"tau_ff[{i + 1}]"] for i in range(n)])[2:]


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Identified]:
    """A rail and an arm of two joints about slanted axes, identified from two motions."""
    folder = tmp_path_factory.mktemp("cart")
    file = folder / "cart.xml"
    file.write_text(machines.CART)
    paths = machines.cart_runs(folder, machines.heavier(machines.CART), (1, 2))
    identified = identify(paths, options=Options(str(file)))
    write_fmu(folder / "inverse.fmu", identified)
    return folder / "inverse.fmu", identified


def held_out() -> tuple[Array, Array, Array]:
    """A motion that nothing was fitted to."""
    return machines.moved(np.arange(500) * TS, 3, (0.25, 0.7, 0.8))


def test_fmu_gives_the_torque_of_pinocchio_and_of_friction(cart: tuple[Path, Identified]) -> None:
    file, identified = cart
    q, v, a = held_out()
    values = {one.name: one.estimate.value for one in identified.parameters}
    model = pin.buildModelFromMJCF(str(file.with_name("cart.xml")))
    for place, body in enumerate(("cart", "arm", "wrist"), start=1):
        ten = [values[f"{body}.{name}"] for name in TEN]
        model.inertias[place] = pin.Inertia.FromDynamicParameters(np.array(ten))
    model.armature = np.array([values["m_r[1]"], values["J_r[2]"], values["J_r[3]"]])
    data = model.createData()
    wanted = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
    for i, form in enumerate(identified.estimated.forms):
        assert form.kind == "rate"
        s = np.tanh((v[:, i] + form.lead * a[:, i]) / form.size)
        wanted[:, i] += values[f"F_c[{i + 1}]"] * s + values[f"d[{i + 1}]"] * v[:, i]
        wanted[:, i] += values.get(f"o[{i + 1}]", 0.0)
    got = played(file, q, v, a)
    assert_close(got, wanted[1:-1], atol=1e-9 * np.abs(wanted).max(), what="tau_ff")


def test_fmu_predicts_the_machine_itself(cart: tuple[Path, Identified]) -> None:
    file, _ = cart
    q, v, a = held_out()
    machine = machines.inverse(machines.heavier(machines.CART), q, v, a)
    machine += machines.rubbed(v, machines.DRY, machines.VISCOUS) + machines.OFFSETS
    got = played(file, q, v, a)
    left = got - machine[1:-1]
    # the sharpness of the dry friction was found from noisy logs
    assert (left.std(axis=0) < 0.005 * machine.std(axis=0)).all()


def test_each_identified_value_can_be_tuned(cart: tuple[Path, Identified]) -> None:
    file, identified = cart
    listed = {v.name: v for v in fmpy.read_model_description(str(file)).modelVariables}
    value = identified["wrist.mc_x"].estimate.value
    tuned = listed["p.wrist.mc_x"]
    assert (tuned.variability, float(tuned.start)) == ("tunable", value)
    assert [listed[name].unit for name in ("p.F_c[1]", "tau_ff[2]", "rd[1]")] == ["N", "N m", "m/s"]
    q, v, a = (part[:20] for part in held_out())
    plain = played(file, q, v, a)
    heavier = played(file, q, v, a, {"p.o[3]": identified["o[3]"].estimate.value + 2.0})
    assert_close(heavier - plain, np.tile([0.0, 0.0, 2.0], (len(plain), 1)), atol=1e-12, what="o")


def test_dry_friction_that_turns_over_with_the_way_keeps_its_state(tmp_path: Path) -> None:
    t = np.arange(5000) * TS
    paths, forces = [], {}
    for seed in (1, 2, 3):
        q, v, a = machines.moved(t, seed, (0.2,))
        z = np.zeros(len(q))
        for k in range(1, len(q)):
            # the same law in another form: a rate of change, in a thousand small steps
            step = (q[k, 0] - q[k - 1, 0]) / 20
            z[k] = z[k - 1]
            for _ in range(20):
                z[k] += (step - abs(step) * z[k]) / 0.004
        forces[seed] = 12.0 * a + 9.0 * v + 30.0 * z[:, None]
        head = f"# trajectory: {seed}\n"
        paths.append(
            machines.write(tmp_path / f"{seed}.csv", t, q, forces[seed], (True,), head, seed)
        )
    identified = identify(paths[:2], options=Options("axis"))
    assert identified.estimated.forms[0].kind == "way"
    got = played(write_fmu(tmp_path / "rail.fmu", identified), *machines.moved(t, 3, (0.2,)))
    left = (got - forces[3][1:-1])[500:]
    assert left.std() < 0.01 * forces[3].std()


def test_an_own_base_is_compiled_through_its_columns(tmp_path: Path) -> None:
    from tests.diagnosis.estimation.test_identified import OWN, arm

    identified = identify(arm(tmp_path, (1, 2)), options=Options(OWN))
    file = write_fmu(tmp_path / "links.fmu", identified)
    q, v, a = (0.5 * part for part in machines.moved(np.arange(200) * TS, 4, (1.0, 1.0)))
    p = np.array([identified[name].estimate.value for name, *_ in example.TwoLinks.parameters])
    wanted = example.TwoLinks().columns(q, v, a) @ p
    for i, form in enumerate(identified.estimated.forms):
        n = i + 1
        s = np.tanh((v[:, i] + form.lead * a[:, i]) / form.size)
        wanted[:, i] += identified[f"F_c[{n}]"].estimate.value * s
        wanted[:, i] += (
            identified[f"d[{n}]"].estimate.value * v[:, i] + identified[f"o[{n}]"].estimate.value
        )
    got = played(file, q, v, a)
    assert_close(got, wanted[1:-1], atol=1e-9 * np.abs(wanted).max(), what="tau_ff")


class _Traced(ColumnBase):
    """A pendulum whose columns are given."""

    def __init__(self, traceable: object) -> None:
        known = Known("J", "kg m2", 1.0, 0.1, "J", 0), Known("g", "N m", 1.0, 0.1, "g", 0)
        super().__init__((ROTARY,), known, TS)
        self.traceable = traceable

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        return np.stack([thetadd, np.sin(theta)], axis=2)


def test_columns_that_take_numbers_alone_are_refused_with_the_reason() -> None:
    def compares(theta: Array, thetad: Array, thetadd: Array) -> Array:
        return np.stack([np.where(theta > 0, theta, 0), thetadd], axis=2)

    with pytest.raises(MachineError, match=re.escape("columns works with numbers alone")):
        symbolic_torque(_Traced(compares), "pendulum")


def test_an_expression_that_gives_other_torques_is_refused() -> None:
    def wrong(theta: Array, thetad: Array, thetadd: Array) -> Array:
        return np.stack([thetadd, np.cos(theta)], axis=2)

    symbolic_torque(_Traced(_Traced(None).columns), "pendulum")
    with pytest.raises(MachineError, match="other torques than with numbers"):
        symbolic_torque(_Traced(wrong), "pendulum")


TREE = """<mujoco><compiler angle="radian"/><option gravity="1 2 -9"/><worldbody>
<body name="trunk"><joint name="turn" axis="0 1 1"/>
<inertial pos="0 .1 .2" mass="5" fullinertia=".2 .3 .25 .01 .02 .03"/>
<body name="left-arm" pos="0 .3 .4" euler=".2 .3 0"><joint name="l" axis="1 0 .5" pos=".1 0 0"/>
<inertial pos=".1 .02 -.2" mass="3" diaginertia=".03 .03 .01"/></body>
<body name="right" pos="0 -.3 .4"><joint name="r" type="slide" axis=".3 1 0"/>
<inertial pos=".1 .02 -.2" mass="2" diaginertia=".03 .02 .01"/>
<body name="hand" pos=".2 0 .1"><joint name="h" axis="0 0 1"/>
<inertial pos=".1 0 .1" mass="1" diaginertia=".01 .02 .01"/></body></body>
</body></worldbody></mujoco>"""


@pytest.mark.parametrize("joints", [("turn", "l", "r", "h"), ("h", "r", "turn"), ("l",)])
def test_a_tree_in_any_order_of_its_axes_is_that_of_pinocchio(
    tmp_path: Path, joints: tuple[str, ...]
) -> None:
    """`symbolic_torque` compares with Pinocchio at random and raises where they differ."""
    from flexhex.diagnosis.basemodels.robot_file import read_robot
    from flexhex.diagnosis.basemodels.robots import RobotBase
    from flexhex.diagnosis.basemodels.tolerances import RobotTolerance

    file = tmp_path / "tree.xml"
    file.write_text(TREE)
    robot = read_robot(file, joints, len(joints))
    symbolic_torque(RobotBase(file, robot, RobotTolerance(), TS), "tree")


@pytest.mark.parametrize("fitted", ["geometry", "gravity"])
def test_fmu_of_fitted_geometry_is_refused(fitted: str, tmp_path: Path) -> None:
    """A tolerance fits what it is of, and nothing else of the geometry."""
    file = tmp_path / "cart.xml"
    file.write_text(machines.CART)
    paths = machines.cart_runs(tmp_path, machines.heavier(machines.CART), (1, 2))
    identified = identify(paths, options=Options(str(file), tolerance={fitted: 0.002}))
    names = [one.name for one in identified.parameters]
    assert any(name.startswith("gravity.") for name in names) == (fitted == "gravity")
    assert any(name.endswith(".roll") for name in names) == (fitted == "geometry")
    with pytest.raises(UsageError, match="--tolerance geometry"):
        write_fmu(tmp_path / "inverse.fmu", identified)
