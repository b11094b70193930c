"""Offsets of the encoders: found in a known pose, kept with date and drives, used by every run."""

from __future__ import annotations

import math
import tomllib
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.gateway.bench import Bench, drive, never_enabled
from tests.gateway.fault_table import Table
from tests.gateway.test_readback import RUN, SHORT, refusal
from tests.gateway.test_refusals import REST_RAD, RESTS
from tests.gateway.test_trust import head
from tests.gateway.weight import QUIET_S, free

COUNTS = (123_456_789, -2_000_000_000, 0, 2_147_483_647, -1, 50_000_000)
OFFSETS = "".join(drive(k, f"offset = {counts}") for k, counts in enumerate(COUNTS))
NAMED = ('# file = "akd-homing.toml"', 'file = "homing.toml"')
ZERO = "0,0,0,0,0,0"


@pytest.fixture(scope="module")
def homed(hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """Drives whose encoders count from anywhere, homed in the neutral pose."""
    bench = Bench(hexapod_ssp, tmp_path_factory.mktemp("homed"))
    command = ("home", "--at", ZERO, "--write", bench.folder / "homing.toml")
    ran = bench.run(options=OFFSETS, command=command)
    assert ran.code == 0, ran.words
    never_enabled(ran)
    assert [axis["offset_counts"] for axis in ran.one("homed")["axis"]] == list(COUNTS)
    return bench


def test_run_with_the_offsets_is_the_same_to_the_last_bit(homed: Bench) -> None:
    plain = homed.run(seconds=0.25)
    assert "axis 1: it rests at 0.18" in refusal(homed.run(options=OFFSETS, command=RUN))
    ran = homed.run(options=OFFSETS, seconds=0.25, changes=(NAMED,))
    assert ran.code == 0, ran.words
    digests = [each.happened("stopped")[0]["digest"] for each in (plain, ran)]
    assert digests[0] == digests[1]
    when = datetime.fromisoformat(head(ran.recording)["homed"])
    assert abs(datetime.now(UTC) - when) < timedelta(hours=1)


def test_drives_other_than_those_that_were_homed_are_refused(homed: Bench) -> None:
    swapped = OFFSETS.replace(f"offset = {COUNTS[0]}\n", f"offset = {COUNTS[0]}\nserial = 1001\n")
    message = refusal(homed.run(options=swapped, command=RUN, changes=(NAMED,)))
    assert "axis 1, position 0: serial is 0x3e9, expected 0x3e8: drives are swapped" in message
    serial = ("# serial = 1002", "serial = 77")
    ran = homed.run(options=OFFSETS, command=RUN, changes=(NAMED, serial))
    assert ran.code == 3
    assert "axis 2: homed with the drive of serial number 1001" in ran.one("refused")["message"]


def test_file_with_a_wrong_digit_is_refused_before_the_bus(homed: Bench) -> None:
    """By 0.07 rad in one axis: no limit of the angles would see it."""
    text = (homed.folder / "homing.toml").read_text()
    assert text.count("123456789") == 1
    (homed.folder / "digit.toml").write_text(text.replace("123456789", "173456789"))
    named = (NAMED[0], 'file = "digit.toml"')
    ran = homed.run(options=OFFSETS, command=RUN, changes=(named,))
    assert ran.code == 3
    assert "a digit was changed after it was written: home" in ran.one("refused")["message"]
    assert not ran.happened("state")


def test_old_file_is_kept_and_another_pose_moves_the_offsets(homed: Bench) -> None:
    file = homed.folder / "again.toml"
    for pose in (ZERO, "-0.1,0,0,0,0,0.2"):
        ran = homed.run(options=OFFSETS, command=("home", "--at", pose, "--write", file))
        assert ran.code == 0, ran.words
    old, new = (
        tomllib.loads(each.read_text()) for each in (homed.folder / "again-old-1.toml", file)
    )
    moved = [
        b["offset_counts"] - a["offset_counts"]
        for a, b in zip(old["axis"], new["axis"], strict=True)
    ]
    turn = 2**32 / (2 * math.pi)
    assert moved == [round(0.1 * turn), 0, 0, 0, 0, -round(0.2 * turn)]
    assert new["pose_rad"] == [-0.1, 0, 0, 0, 0, 0.2]
    for wrong in ("0,0", "0,0,0,0,0,11"):
        assert homed.run(command=("home", "--at", wrong)).code == 2
    assert homed.run(command=RUN, changes=(NAMED,), seconds=SHORT).code == 1, "other counts"


def test_machine_that_was_let_go_rests_where_the_file_says(homed: Bench) -> None:
    """A jig says nothing of the rest pose; an offset that is wrong is seen only against it."""
    file = homed.folder / "let-go.toml"
    named = (NAMED[0], f'file = "{file.name}"')
    rest = ("home", "--rest", "--write", file)
    assert homed.run(options=OFFSETS, command=rest).code == 2, "offsets are not known yet"
    fallen = free(homed, OFFSETS, resting=QUIET_S, changes=(NAMED,), command=rest)
    assert fallen.ran.code == 0, fallen.ran.words
    never_enabled(fallen.ran)
    record = tomllib.loads(file.read_text())
    assert [axis["offset_counts"] for axis in record["axis"]] == list(COUNTS)
    assert record["pose_rad"] == [0.0] * 6
    assert free(homed, OFFSETS, changes=(named,), seconds=0.05).ran.code == 0
    # as if the machine had been homed with axis 3 elsewhere
    off = round(0.12 * 2**32 / (2 * math.pi))
    text = file.read_text().replace(f'sum = "{record["sum"]}"\n', "")
    file.write_text(text.replace("offset_counts = 0\n", f"offset_counts = {off}\n"))
    fallen = free(homed, OFFSETS, changes=(named,))
    event = fallen.ran.one("refused")
    assert event["kind"] == "not_as_homed"
    assert "axis 3: theta = -" in event["message"]
    never_enabled(fallen.ran)


def test_offsets_are_written_of_a_pose_that_is_named(hexapod_ssp: Path, tmp_path: Path) -> None:
    """A machine that lies at rest would be said to be in its neutral pose."""
    bench, file = Bench(hexapod_ssp, tmp_path), tmp_path / "homing.toml"
    ran = bench.run(command=("home", "--write", file))
    assert ran.code == 2, ran.words
    assert "<--at <RAD,...>|--stops|--rest>" in ran.words
    assert not file.exists()
    assert bench.run(command=("home",)).one("homed")["pose_rad"] == [0.0] * 6


TURNED = ("# serial = 1003\ndirection = 1", "# serial = 1003\ndirection = -1")
"""Torque and angle of axis 3 both count the other way."""


def test_axis_that_rests_above_its_weight_is_refused(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """Where both count the other way the feedback would hold it, in a mirrored pose."""
    bench = Bench(hexapod_ssp, tmp_path)
    for name, options, changes in (
        ("direction of an axis is wrong", "", (TURNED,)),
        (
            "encoder counts the wrong way from the start",
            drive(2, "encoder_reversed = true"),
            (),
        ),
    ):
        fallen = free(bench, options, changes=changes)
        assert fallen.ran.code == 1
        event = fallen.ran.one("refused")
        assert event["kind"] == "against_weight"
        assert "axis 3: it rests at 0.2" in event["message"]
        assert "drive[2].direction" in event["message"]
        never_enabled(fallen.ran)
        falls.add(fallen.refused(name))
    resting = (REST_RAD, RESTS[1].replace("-0.23", "0.23"))
    assert free(bench, changes=(TURNED, resting), seconds=0.05).ran.code == 0, (
        "somebody knows better"
    )
