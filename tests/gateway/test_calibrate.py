"""`calibrate`: signs by a nudge of each axis, the torque constant by a known mass."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.bench import Bench, Ran, drive
from tests.gateway.test_falls import NOT_COMPARED
from tests.gateway.weight import Fallen, free

masses = pytest.mark.sample(1, of="calibration by a mass")

SIGNS = ("calibrate", "signs")
TORQUE = ("calibrate", "torque")
POWER = ("--enable", "--lockstep")


def pushed(bench: Bench, options: str = "", *more: object) -> Fallen:
    """A nudge of every axis of a machine that nothing holds, and that still swings a little."""
    return free(bench, options, command=(*SIGNS, *POWER, *more))


def test_signs_of_a_sound_machine(hexapod_ssp: Path, tmp_path: Path) -> None:
    file = tmp_path / "signs.toml"
    # encoders need not be homed
    offsets = "".join(drive(k, f"offset = {k * 1_000_000_000 - 2_000_000_000}") for k in range(6))
    fallen = pushed(Bench(hexapod_ssp, tmp_path), offsets, "--write", file)
    ran = fallen.ran
    assert ran.code == 0, ran.words
    axes = ran.one("signs")["axis"]
    assert [axis["fault"] for axis in axes] == [""] * 6
    assert all(0.003 <= axis["moved_rad"] < 0.004 for axis in axes)
    assert [axis["serial"] for axis in tomllib.loads(file.read_text())["axis"]] == [
        1000 + k for k in range(6)
    ]
    assert np.abs(fallen.tau).max() < 0.502
    fallen.ends_at_rest(0)


@pytest.mark.parametrize(
    ("options", "axis", "fault"),
    [
        (drive(3, "encoder_reversed = true"), 4, "it moved against its torque"),
        ("drives.order = [1, 0, 2, 3, 4, 5]\n", None, None),
    ],
)
def test_wrong_signs_are_reported_without_feedback(
    options: str, axis: int | None, fault: str | None, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Drives in another order are only that: torque and encoder of each belong together."""
    fallen = pushed(Bench(hexapod_ssp, tmp_path), options)
    signs = fallen.ran.one("signs")["axis"]
    wrong = [k + 1 for k, axis in enumerate(signs) if axis["fault"]]
    assert wrong == ([axis] if axis else [])
    assert fallen.ran.code == (1 if axis else 0)
    if fault:
        assert signs[3]["fault"].startswith(fault)
        assert "do not run" in fallen.ran.one("refused")["message"]
    fallen.ends_at_rest(0)


def test_blocked_axis_is_reported(hexapod_ssp: Path, tmp_path: Path) -> None:
    fallen = pushed(Bench(hexapod_ssp, tmp_path), "", "--torque", 0.001)
    assert fallen.ran.code == 1
    assert all("hardly moved" in axis["fault"] for axis in fallen.ran.one("signs")["axis"])


def loaded_run(bench: Bench, constant: float, mass: float, *more: object) -> Ran:
    """Holding torques of a machine with another torque constant, and a mass."""
    payload = {"count": 1, "time[1]": 0, "mass[1]": mass}
    parameters = ", ".join(f'"reference.payload_{k}" = {v}' for k, v in payload.items())
    options = f"drives.torque_constant = {constant}\nplant.parameters = {{ {parameters} }}\n"
    return free(bench, options, changes=(NOT_COMPARED,), command=(*TORQUE, *POWER, *more)).ran


@masses
@pytest.mark.parametrize(
    ("constant", "why"),
    [
        (3.0, None),
        (3.0 / math.sqrt(2), "the configuration has 3, wrong by 1.4"),
        (3.0 * math.sqrt(2), "the configuration has 3, wrong by 1.4"),
    ],
)
def test_torque_constant_is_found_by_a_mass(
    constant: float, why: str | None, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """One that the configuration does not have is an error, and is written all the same."""
    bench = Bench(hexapod_ssp, tmp_path)
    empty, loaded = tmp_path / "empty.toml", tmp_path / "loaded.toml"
    ran = loaded_run(bench, constant, 0, "--write", empty)
    assert ran.code == 0, ran.words
    ran = loaded_run(bench, constant, 1.0, "--mass", 1.0, "--against", empty, "--write", loaded)
    assert ran.code == (1 if why else 0), ran.words
    assert not why or why in ran.one("refused")["message"]
    event = ran.one("torque_constant")
    # friction of the drives is the same both times, up to its hysteresis
    assert event["mean"] == pytest.approx(constant, rel=0.01)
    assert event["spread"] < 0.02
    assert tomllib.loads(loaded.read_text())["scales"] == event["scales"]
    wrong = loaded_run(bench, constant, 1.0, "--mass", 1.0, "--against", loaded)
    assert wrong.code == 2
    assert "a run with 1 kg, not one without" in wrong.one("refused")["message"]


@masses
def test_mass_that_is_not_there_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    empty = tmp_path / "empty.toml"
    assert loaded_run(bench, 3.0, 0, "--write", empty).code == 0
    ran = loaded_run(bench, 3.0, 0, "--mass", 1.0, "--against", empty)
    assert ran.code == 1
    assert "the mass should add" in ran.one("refused")["message"]
    ran = loaded_run(bench, 3.0, 0, "--mass", 0.01, "--against", empty)
    assert "take a larger one" in ran.one("refused")["message"]
    for more in (("--mass", 1), ("--mass", 99, "--against", empty), ("--against", empty)):
        assert loaded_run(bench, 3.0, 0, *more).code == 2
