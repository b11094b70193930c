"""The machine file that a diagnosis writes: exactly its numbers, and the original untouched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.machine_files.extend import extend, extended_file
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Changed, Diagnosis, Named, Residual
from flexhex.fmus.common.machine_file import load_machine, real_file, truth_file
from flexhex.fmus.common.model.bodies import inertia, point_mass
from tests.conftest import MACHINE_FILE

Parts = tuple[tuple[int, dict[str, Estimate]], ...]
NOTHING = np.full(6, np.nan)


def estimate(value: float, unit: str) -> Estimate:
    return Estimate(value, (value - 0.01, value + 0.01), unit)


def cogging(axis: int, a: float, b: float, order: float) -> tuple[int, dict[str, Estimate]]:
    values = {"a": estimate(a, "N m"), "b": estimate(b, "N m")}
    return axis, {**values, "order": estimate(order, "1/rad")}


def named(id: str, parts: Parts, rivals: tuple[str, ...] = ()) -> Named:
    axes = tuple(sorted({axis for axis, _ in parts if axis}))
    return Named(id, id, axes, {}, parts, rivals)


def diagnosis(effects: tuple[Named, ...] = (), changed: tuple[Changed, ...] = ()) -> Diagnosis:
    residual = Residual(("N m",) * 6, *(NOTHING for _ in range(7)))
    return Diagnosis("named", effects, changed, residual, runs=("logs/a1.h5",))


def changed(parameter: str, nominal: float, value: float, unit: str) -> Changed:
    return Changed(parameter, nominal, estimate(value, unit))


def test_extended_file_holds_several_orders_on_several_axes_exactly(tmp_path: Path) -> None:
    parts = (
        cogging(2, 0.1 / 3, -0.004, 360.1 + 1e-13),
        cogging(4, 0.2 / 3, 0.007, 360.1 + 1e-13),
        cogging(2, 0.001, 0.002, 432.0),
    )
    before = MACHINE_FILE.read_bytes()
    path = extended_file(
        MACHINE_FILE, diagnosis((named("cogging_harmonic", parts),)), tmp_path / "sub" / "new.toml"
    )
    uses = load_machine(path).effects
    assert [use.axes for use in uses] == [(2, 4), (2,)]
    assert uses[0].gains == ((0.1 / 3, 0.2 / 3), (-0.004, 0.007))
    assert uses[0].shapes == (360.1 + 1e-13,)
    assert (uses[1].gains, uses[1].shapes) == (((0.001,), (0.002,)), (432.0,))
    assert MACHINE_FILE.read_bytes() == before
    assert f'extends = "{Path.cwd().anchor}' not in path.read_text(), "the path must be relative"


def test_extended_file_says_that_a_set_is_undecided(tmp_path: Path) -> None:
    effect = named("cubic_stiffness", ((3, {"k_3": estimate(2.0, "N m/rad3")}),), ("cable_force",))
    text = extended_file(MACHINE_FILE, diagnosis((effect,)), tmp_path / "new.toml").read_text()
    assert "do not tell it from cable_force" in text
    assert "ci95 = [[1.99, 2.01]]" in text


def test_extended_file_belongs_to_the_same_real_machine(tmp_path: Path) -> None:
    path = extended_file(MACHINE_FILE, diagnosis(), tmp_path / "new.toml")
    assert real_file(path).resolve() == MACHINE_FILE.resolve()
    assert real_file(MACHINE_FILE) == MACHINE_FILE
    assert truth_file(path).resolve() == truth_file(MACHINE_FILE).resolve()


def test_changed_parameters_reach_their_sections(tmp_path: Path) -> None:
    changes = (
        changed("actuator[3].o", -1.6, -1.7, "N m"),
        changed("actuator[6].b[9]", 0.02305, 0.1 / 3, "N m"),
        changed("flexure.k_s1", 0.3, 0.4, "N m/rad"),
        changed("upper.J", 0.02, 0.021, "kg m2"),
    )
    before = load_machine(MACHINE_FILE)
    after = load_machine(extended_file(MACHINE_FILE, diagnosis((), changes), tmp_path / "new.toml"))
    assert after.actuator.o == (*before.actuator.o[:2], -1.7, *before.actuator.o[3:])
    assert after.actuator.b[5][8] == 0.1 / 3
    assert after.actuator.b[:5] == before.actuator.b[:5]
    assert after.flexures is not None
    assert after.flexures.k_s == (0.4, 0.45)
    arm = after.bodies.upper
    # a sum of three terms of 1e-2: rounding only
    assert inertia(arm)[5] + arm.J_rotor == pytest.approx(0.021, abs=1e-17)
    assert (arm.m, arm.c, arm.Ic) == tuple(
        getattr(before.bodies.upper, k) for k in ("m", "c", "Ic")
    )
    assert (after.bodies.lower, after.drive) == (before.bodies.lower, before.drive)


def test_changed_mass_alone_is_a_payload(tmp_path: Path) -> None:
    changes = (changed("end_effector.m", 1.25, 1.75, "kg"),)
    before = load_machine(MACHINE_FILE).platform.end_effector
    after = load_machine(extended_file(MACHINE_FILE, diagnosis((), changes), tmp_path / "new.toml"))
    body = after.platform.end_effector
    assert body.m == 1.75
    wanted = inertia(before) + np.array(point_mass(0.5, before.c_payload)).ravel()
    # twice through Huygens-Steiner: rounding only
    np.testing.assert_allclose(inertia(body), wanted, rtol=0, atol=1e-16)


def test_changed_mass_and_centre_hold_as_given(tmp_path: Path) -> None:
    changes = (
        changed("end_effector.m", 1.25, 1.35, "kg"),
        changed("end_effector.mc_x", 0.0025, 0.003, "kg m"),
        changed("end_effector.J_zz", 0.12, 0.125, "kg m2"),
    )
    after = load_machine(extended_file(MACHINE_FILE, diagnosis((), changes), tmp_path / "new.toml"))
    ten = inertia(after.platform.end_effector)
    np.testing.assert_allclose(ten[[0, 1, 6]], [1.35, 0.003, 0.125], rtol=1e-14)


def test_what_a_file_cannot_hold_is_returned_and_noted(tmp_path: Path) -> None:
    changes = (
        changed("sigma[2]", 0.015, 0.02, "rad"),
        changed("flexure[2].k_s1", 0.3, 0.4, "N m/rad"),
        changed("actuator[1].d", 0.012, -0.01, "N m s/rad"),
        changed("end_effector.J_xx", 0.06, 5.0, "kg m2"),
    )
    lag = named("drive_lag", ((3, {"T_lag": estimate(-0.02, "s")}),))
    extended = extend(MACHINE_FILE, diagnosis((lag,), changes), tmp_path / "new.toml")
    assert len(extended.left_out) == 5
    for text, part in zip(
        sorted(extended.left_out),
        (
            "actuator[1].d",
            "drive_lag on axis 3",
            "end_effector.J_xx",
            "flexure[2].k_s1",
            "sigma[2]",
        ),
        strict=True,
    ):
        assert text.startswith(part)
        assert f"# Not in here: {text}" in extended.path.read_text()
    machine, before = load_machine(extended.path), load_machine(MACHINE_FILE)
    assert machine == before


@pytest.mark.parametrize("name", ["upper[2].J", "lower[6].m", "flexure[5].k_u2"])
def test_part_of_one_arm_is_said_not_to_be_written(name: str, tmp_path: Path) -> None:
    extended = extend(
        MACHINE_FILE, diagnosis((), (changed(name, 0.1, 0.2, "kg"),)), tmp_path / "new.toml"
    )
    (text,) = extended.left_out
    assert text.startswith(f"{name} from 0.1 to 0.2 kg")
    assert "one such part for all arms: not written" in text
    assert load_machine(extended.path) == load_machine(MACHINE_FILE)


def test_changed_geometry_is_said_not_to_be_written(tmp_path: Path) -> None:
    change = changed("arm[2].L", 0.0, 1e-3, "m")
    extended = extend(MACHINE_FILE, diagnosis((), (change,)), tmp_path / "new.toml")
    (text,) = extended.left_out
    assert text == "arm[2].L from 0 to 0.001 m (the loops must close at neutral: not written)"


def test_effect_found_again_with_its_shape_grows(tmp_path: Path) -> None:
    once = diagnosis((named("cogging_harmonic", (cogging(2, 0.5, 0.25, 360.0),)),))
    first = extended_file(MACHINE_FILE, once, tmp_path / "first.toml")
    more = (cogging(2, 0.125, 0.0, 360.0), cogging(3, 0.125, 0.0, 360.0))
    again = diagnosis((named("cogging_harmonic", more),))
    uses = load_machine(extended_file(first, again, tmp_path / "second.toml")).effects
    assert [(use.axes, use.gains) for use in uses] == [
        ((2,), ((0.625,), (0.25,))),
        ((3,), ((0.125,), (0.0,))),
    ]
    assert load_machine(first).effects[0].gains == ((0.5,), (0.25,))


def test_gain_that_noise_pushed_below_zero_is_zero(tmp_path: Path) -> None:
    parts = {
        "F_c": Estimate(0.03, (0.02, 0.04), "N m"),
        "F_s": Estimate(-0.002, (-0.006, 0.002), "N m"),
        "v_s": Estimate(0.05, (0.01, 0.09), "rad/s"),
        "s_0": Estimate(0.001, (0.0, 0.002), "rad"),
    }
    example = diagnosis((named("stribeck_friction", ((3, parts),)),))
    done = extend(MACHINE_FILE, example, tmp_path / "new.toml")
    assert not done.left_out
    assert load_machine(done.path).effects[0].gains == ((0.03,), (0.0,))
    # one that is surely negative is none that the file could hold
    parts["F_s"] = Estimate(-0.02, (-0.024, -0.016), "N m")
    done = extend(MACHINE_FILE, example, tmp_path / "new.toml")
    assert "stribeck_friction on axis 3" in done.left_out[0]


def test_friction_gives_way_within_what_the_plant_integrates(tmp_path: Path) -> None:
    machine = load_machine(MACHINE_FILE)

    def angle(value: float) -> float:
        parts = {
            "F_c": Estimate(0.0107, (0.009, 0.012), "N m"),
            "s_0": Estimate(value, (-np.inf, np.inf), "rad"),
        }
        example = diagnosis((named("coulomb_friction", ((3, parts),)),))
        (use,) = load_machine(extended_file(MACHINE_FILE, example, tmp_path / "new.toml")).effects
        return use.shape["s_0"]

    stiffness = 0.0107 / angle(1e-6)
    assert stiffness * machine.timing.base**2 / machine.control.J_design <= 0.0021
    assert angle(1e-4) == 1e-4, "what can be integrated stays"
