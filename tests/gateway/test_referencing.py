"""`home --stops`: each axis finds its end stop at low torque, whatever its encoder shows."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.bench import Bench, never_enabled
from tests.gateway.fault_table import Table
from tests.gateway.test_homing import COUNTS, NAMED, OFFSETS
from tests.gateway.weight import QUIET_S, STROKE, Fallen, free

FAST = ("--set", "homing.speed_rad_per_s=0.3")
HOME = ("home", "--stops", "--enable", "--lockstep")
STEP = 2 * np.pi / 2**32


def homed(bench: Bench, *more: object, options: str = OFFSETS) -> Fallen:
    """A referencing run of a machine that nothing holds."""
    return free(bench, options, resting=QUIET_S, command=(*HOME, *more))


@pytest.fixture(scope="module")
def referenced(hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Bench, Fallen]:
    """A referencing run of drives whose encoders count from anywhere."""
    bench = Bench(hexapod_ssp, tmp_path_factory.mktemp("stops"))
    return bench, homed(bench, *FAST, "--write", bench.folder / "homing.toml")


def test_offsets_are_found_at_the_stops(referenced: tuple[Bench, Fallen]) -> None:
    bench, fallen = referenced
    ran = fallen.ran
    assert ran.code == 0, ran.words
    record = tomllib.loads((bench.folder / "homing.toml").read_text())
    assert record["method"] == "stops"
    offsets = np.array([axis["offset_counts"] for axis in record["axis"]])
    off = (offsets - np.array(COUNTS)).astype(np.int32) * STEP
    # half a cycle of the speed: where it stood in the cycle before it met the stop
    assert np.abs(off).max() < 1e-4, off
    assert np.allclose(record["pose_rad"], fallen.theta[0], atol=1e-3)
    assert [axis["serial"] for axis in record["axis"]] == [1000 + k for k in range(6)]


def test_machine_is_pressed_with_little_torque_only_and_ends_where_it_rested(
    referenced: tuple[Bench, Fallen],
) -> None:
    fallen = referenced[1]
    pressing = fallen.theta < -STROKE + 1e-5
    # the way back begins there, too
    assert -0.6 <= fallen.tau[pressing].min() < -0.59, "homing.torque_N_m"
    assert np.abs(fallen.tau).max() < 2.0
    assert fallen.theta.min() >= -STROKE
    # each axis meets its stop twice
    for axis in range(6):
        at = np.abs(fallen.theta[:, axis] + STROKE) < 1e-3
        assert np.count_nonzero(np.diff(at.astype(int)) == 1) == 2, axis
    fallen.ends_at_rest(0)
    # friction holds it within a band
    assert np.abs(fallen.theta[-1] - fallen.theta[0]).max() < 0.06
    assert fallen.speed.max() < 1.0


def test_run_with_these_offsets_tracks_as_with_the_right_ones(
    referenced: tuple[Bench, Fallen],
) -> None:
    bench, _ = referenced
    fallen = free(bench, OFFSETS, changes=(NAMED,), seconds=1.0)
    assert fallen.ran.code == 0, fallen.ran.words
    assert max(fallen.ran.one("summary")["largest_error_rad"]) < 0.01


def wrong(bench: Bench, axis: int, off: float) -> Path:
    """The file with the offset of an axis wrong by an angle [rad], as if it was found so."""
    record = tomllib.loads((bench.folder / "homing.toml").read_text())
    counts = record["axis"][axis]["offset_counts"]
    text = (bench.folder / "homing.toml").read_text().replace(f'sum = "{record["sum"]}"\n', "")
    assert text.count(str(counts)) == 1
    file = bench.folder / f"wrong-{axis}.toml"
    file.write_text(text.replace(str(counts), str(counts - round(off / STEP))))
    return file


@pytest.mark.parametrize(("axis", "off"), [(0, 0.12), (3, -0.12)])
def test_wrong_offset_rests_elsewhere_than_at_homing_and_is_refused(
    axis: int, off: float, referenced: tuple[Bench, Fallen], falls: Table
) -> None:
    """No `landing.rest_rad` is needed: the file says where the machine rested."""
    bench, _ = referenced
    named = (NAMED[0], f'file = "{wrong(bench, axis, off).name}"')
    fallen = free(bench, OFFSETS, changes=(named,))
    assert fallen.ran.code == 1
    event = fallen.ran.one("refused")
    assert event["kind"] == "not_as_homed"
    assert f"axis {axis + 1}: theta = -" in event["message"]
    why = "when it was homed (rest_rad or pose_rad in homing.file), more than 0.1 rad away"
    assert why in event["message"]
    never_enabled(fallen.ran)
    if axis == 0:
        falls.add(fallen.refused("offset of the homing file wrong by 0.12 rad"))


def test_machine_that_rests_a_little_elsewhere_runs(referenced: tuple[Bench, Fallen]) -> None:
    """Friction holds it within 0.06 rad of where it rested; here the offset is wrong by so much."""
    bench, _ = referenced
    named = (NAMED[0], f'file = "{wrong(bench, 0, 0.06).name}"')
    assert free(bench, OFFSETS, changes=(named,), seconds=0.05).ran.code == 0


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("homing.within_rad=0.1", "axis 1: no end stop within 0.1 rad of the rest pose"),
        ("landing.rest_rad=[0.1,-0.35,-0.34,-0.37,-0.35,-0.37]",
         "axis 1: by its stop it rested at -"),
    ],
)  # fmt: skip
def test_what_is_no_stop_is_refused_and_lands(
    change: str, why: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    fallen = homed(
        Bench(hexapod_ssp, tmp_path), *FAST, "--set", change, "--write", tmp_path / "homing.toml"
    )
    assert fallen.ran.code == 1
    assert why in fallen.ran.one("refused")["message"]
    assert not (tmp_path / "homing.toml").exists()
    fallen.ends_at_rest(0)


@pytest.mark.sample(2)
@pytest.mark.parametrize("cycle", [1000, 2000, 3200, 9000])
def test_frozen_encoder_is_no_stop(
    cycle: int, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """On the way from rest, in the pause before the search, at its begin, in its middle."""
    fault = f'[[fault]]\ncycle = {cycle}\nkind = "encoder_frozen"\nposition = 0\n'
    fallen = homed(Bench(hexapod_ssp, tmp_path), options=OFFSETS + fault)
    assert fallen.ran.code == 1
    said = fallen.ran.words
    assert "axis 1: encoder counts constant" in said or "axis 1: its encoder stands still" in said
    fallen.ends_at_rest(0)
    if cycle == 9000:
        name = "encoder frozen while its end stop is sought"
        assert fallen.ran.one("summary")["not_disabled"] == []
        falls.add(fallen.fall(name, cycle))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("homing.torque_N_m=7", "homing.torque_N_m = 7, allowed 0.001 to 6"),
        ("homing.stop_rad=[-0.5,-0.5,-0.5,0.5,-0.5,-0.5]", "homing.stop_rad[3] = 0.5"),
    ],
)
def test_wrong_values_are_refused_without_power(
    change: str, why: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(command=(*HOME, "--set", change))
    assert ran.code == 3
    assert why in ran.one("refused")["message"]
    never_enabled(ran)
