"""`[[effects]]` of a machine file: what it gives, and one clear message for each mistake."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.effect_use import EffectUse
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from tests.blocks.loaded import machine
from tests.effects.machines import axis_of, machine_file, on_axes, use

ENTRY = """
[[effects]]
id = "coulomb_friction"
axes = [3, 5]
[effects.parameters]
F_c = { value = [0.05, 0.04], unit = "N m", source = "diagnosed", ci95 = [0.04, 0.06] }
s_0 = { value = 0.002, unit = "rad", source = "assumed", note = "as found" }
"""
AGAIN = ENTRY.replace("[3, 5]", "[3, 4]")
TILT = """
[[effects]]
id = "gravity_tilt"
[effects.parameters]
tilt_x = { value = 0.01, unit = "rad", source = "measured" }
tilt_y = { value = 0.0, unit = "rad", source = "measured" }
"""
BUMP = """
[[effects]]
id = "cable_force"
axes = [1]
[effects.parameters]
k_c = { value = 0.3, unit = "N m/rad", source = "diagnosed" }
theta_0 = { value = 0.05, unit = "rad", source = "diagnosed" }
side = { value = 0.0, unit = "1", source = "diagnosed" }
"""

WRONG = {
    "unknown id": (
        ENTRY.replace("coulomb_friction", "coulomb_frictions"),
        r"effects\.1: there is no effect 'coulomb_frictions', did you mean 'coulomb_friction'\?",
    ),
    "friction too stiff": (
        ENTRY.replace("0.002", "1e-6"),
        r"effects\.1: coulomb_friction gives way within s_0 = 1e-06 rad, at least .* widen s_0",
    ),
    "axis beyond": (ENTRY.replace("[3, 5]", "[3, 7]"), r"effects\.1: axes: 7, .* 1 to 6"),
    "axis zero": (
        ENTRY.replace("[3, 5]", "[0, 5]"),
        r"effects\.1\.axes\.1: is 0, must be at least 1",
    ),
    "axis twice": (ENTRY.replace("[3, 5]", "[3, 3]"), r"effects\.1: axes: .* names an axis twice"),
    "no axes": (ENTRY.replace("axes = [3, 5]\n", ""), r"effects\.1: axes: wants a list of axes"),
    "wrong unit": (
        ENTRY.replace('"N m"', '"mN m"'),
        r"effects\.1: parameters\.F_c: is in 'mN m', wanted 'N m'",
    ),
    "out of bounds": (
        ENTRY.replace("0.05,", "-0.05,"),
        r"effects\.1: parameters\.F_c: -0\.05 N m, must be at least 0\.0 N m",
    ),
    "shape out of bounds": (
        ENTRY.replace("value = 0.002", "value = 2.0"),
        r"effects\.1: parameters\.s_0: 2\.0 rad, must be at most 0\.006 rad",
    ),
    "missing": (
        ENTRY.replace("s_0 = ", "#"),
        r"effects\.1: parameters\.s_0: is missing; coulomb_friction has F_c, s_0",
    ),
    "too many": (
        ENTRY + 'D = { value = 1.0, unit = "1", source = "assumed" }\n',
        r"effects\.1: parameters\.D: coulomb_friction has only F_c, s_0",
    ),
    "a value for each axis": (ENTRY.replace("[0.05, 0.04]", "[0.05]"), r"F_c: wants 2 entries"),
    "no parameters": (
        ENTRY.replace("[effects.parameters]", "[effects.parameter]"),
        r"effects\.1: wants id, axes and a table \[effects\.parameters\]",
    ),
    "unknown key": (ENTRY.replace("axes", "joints = [1]\naxes"), r"effects\.1: 'joints' is not a"),
    "twice": (ENTRY + AGAIN, r"effects\.2: coulomb_friction is there already on axis 3 with the"),
    "tilt with axes": (
        TILT.replace('tilt"', 'tilt"\naxes = [1]'),
        r"effects\.1: axes: gravity_tilt belongs to the whole machine, take axes out",
    ),
    "tilt twice": (TILT + TILT, r"effects\.2: gravity_tilt is there already: keep one"),
    "no such side": (BUMP, r"effects\.1: parameters\.side: 0, allowed: -1, 1"),
}


def test_shape_that_may_be_left_out_has_its_usual_value() -> None:
    """Files from before friction could turn over within a rate mean what they meant."""
    old = EffectUse.of("coulomb_friction", [1], F_c=0.05, s_0=0.002)
    assert old.shape == {"s_0": 0.002, "v_0": 0.0}
    wide = EffectUse.of("coulomb_friction", [1], F_c=0.05, s_0=0.002, v_0=0.03)
    assert wide.shape["v_0"] == 0.03
    with pytest.raises(ValueError, match="s_0: is missing"):
        EffectUse.of("coulomb_friction", [1], F_c=0.05, v_0=0.03)


def written(folder: Path, text: str) -> Path:
    path = machine_file(folder)
    path.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")
    return path


@pytest.mark.parametrize("case", WRONG)
def test_wrong_effect_is_one_clear_message(case: str, tmp_path: Path) -> None:
    text, message = WRONG[case]
    path = written(tmp_path, text)
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    assert re.search(message, str(caught.value)), str(caught.value)
    assert str(path) in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_effects_come_behind_the_162_parameters(tmp_path: Path) -> None:
    other = ENTRY.replace("value = 0.002", "value = 0.004")
    subject = load_machine(written(tmp_path, ENTRY + TILT + other))
    listed, p = parameters(subject), base_parameters(subject)
    assert [par.name for par in listed[162:]] == [
        "coulomb_friction.F_c[3]",
        "coulomb_friction.F_c[5]",
        "coulomb_friction_2.F_c[3]",
        "coulomb_friction_2.F_c[5]",
    ]
    assert {(par.unit, par.body, par.floor) for par in listed[162:]} == {("N m", "effects", 0.02)}
    assert p[162:].tolist() == [0.05, 0.04, 0.05, 0.04]
    assert listed[:162] == parameters(machine())
    assert np.array_equal(p[:162], base_parameters(machine()))


def test_effects_without_feedforward_are_in_the_plant_alone(tmp_path: Path) -> None:
    subject = load_machine(machine_file(tmp_path, use("encoder_eccentricity"), use("drive_gain")))
    ring, gain = axis_of("encoder_eccentricity"), f"drive_gain.g[{axis_of('drive_gain')}]"
    assert [par.name for par in parameters(subject)[162:]] == [gain]
    both = (f"encoder_eccentricity.e_c[{ring}]", f"encoder_eccentricity.e_s[{ring}]")
    assert Bank.all(subject).names == (*both, gain)


def test_machine_file_reads_back_what_was_written(tmp_path: Path) -> None:
    entries = (*(use(id) for id in on_axes()), use("gravity_tilt"))
    assert load_machine(machine_file(tmp_path, *entries)).effects == entries


def test_entry_from_plain_numbers_is_checked_too() -> None:
    entry = EffectUse.of("cubic_stiffness", [1, 2], k_3=(1.0, 2.0))
    assert entry.gains == ((1.0, 2.0),)
    with pytest.raises(ValueError, match=r"k_3: \d+\.0 N m/rad3, must be at most 10000000\.0"):
        EffectUse.of("cubic_stiffness", [1], k_3=1e8)
