"""Tolerances of a machine file, or those given in their place, are those of the base model."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.hexapod import HexapodBase
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, machine_data

MACHINE, ARM = Path("machines/tflex.toml"), "tests/diagnosis/robots/arm.urdf"
LOG = Log.of("made", 1e-3, np.zeros((10, 6)), np.zeros((10, 6)))
KNOWN_BY = {
    "mass": "lower[2].m",
    "inertia": "end_effector.J_xx",
    "centre": "end_effector.mc_z",
    "stiffness": "flexure[3].k_u2",
    "actuator": "actuator[4].o",
    "sigma": "sigma[1]",
    "geometry": "arm[5].l",
}
"""A parameter that each tolerance is of."""


def spreads(base: HexapodBase) -> dict[str, float]:
    geometry = base.geometry.known if base.geometry else ()
    return {k.name: k.tolerance for k in (*base.linear, *base.curved, *base.widths, *geometry)}


@cache
def usual() -> dict[str, float]:
    return spreads(HexapodBase(load_machine(MACHINE)))


@pytest.mark.sample(3)
@pytest.mark.parametrize("key", KNOWN_BY)
def test_tolerance_of_a_file_is_that_of_its_parameters(key: str) -> None:
    data = machine_data(MACHINE)
    wider = 2 * getattr(load_machine(MACHINE).tolerance, key)
    data["tolerance"] = {key: {"value": wider, "unit": "1", "source": "assumed"}}
    base = HexapodBase(Machine.model_validate(data))
    more = spreads(base)
    name = KNOWN_BY[key]
    # a moment m c has the errors of its mass as well
    low = 1.0 if key == "centre" else 1.999
    assert low < more[name] / usual()[name] <= 2.0
    others = {name for other, name in KNOWN_BY.items() if other != key}
    if key != "mass":
        assert all(more[name] == usual()[name] for name in others)
    given = base_of("hexapod", MACHINE, LOG, {key: wider})
    assert isinstance(given, HexapodBase)
    assert spreads(given) == more


def test_what_the_file_has_not_is_not_in_the_base_and_what_it_does_not_know_is_free() -> None:
    data, zero = machine_data(MACHINE), [0.0] * 6
    for name in ("o", "k", "d", "c"):
        data["actuator"][name]["value"] = zero
    for name in ("a", "b"):
        data["actuator"][name]["value"] = [
            [0.0, *own[1:]] for own in data["actuator"][name]["value"]
        ]
    machine = Machine.model_validate(data)
    result, terms = spreads(HexapodBase(machine)), machine.actuator
    assert [result[f"actuator[2].{name}"] for name in "okd"] == [np.inf] * 3
    assert [result[f"actuator[2].{name}"] for name in ("c", "a[1]", "b[1]")] == [0.0] * 3
    wave = 0.05 * np.hypot(terms.a[1][1], terms.b[1][1])
    assert (result["actuator[2].a[2]"], result["actuator[2].b[2]"]) == pytest.approx((wave, wave))


def test_geometry_without_a_tolerance_has_no_columns() -> None:
    base = base_of("hexapod", MACHINE, LOG, {"geometry": 0.0})
    assert base.geometry is None


def test_tolerances_of_a_base_model_without_a_file_are_refused() -> None:
    with pytest.raises(UsageError, match="base model axis reads no machine file"):
        base_of("axis", None, LOG, {"mass": 0.1})


def test_tolerances_that_a_base_model_does_not_use_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"tolerance 'gravity': there are mass, .*sigma$"):
        base_of("hexapod", MACHINE, LOG, {"gravity": 0.01})
    with pytest.raises(UsageError, match=r"tolerance 'sigma': there are mass, .*gravity, effects$"):
        base_of(ARM, None, Log.of("made", 1e-3, *np.zeros((2, 10, 6))), {"sigma": 0.01})
    file = tmp_path / "leaning.toml"
    given = '\n[tolerance]\ngravity = { value = 0.01, unit = "1", source = "assumed" }\n'
    file.write_text(MACHINE.read_text(encoding="utf-8") + given, encoding="utf-8")
    with pytest.raises(MachineError, match=r"leaning.toml: tolerance.gravity: is not a known key"):
        base_of("hexapod", file, LOG)
