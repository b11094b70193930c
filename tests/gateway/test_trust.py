"""`off`, rights, limits, other devices, recordings: what a lab trusts before and after a run."""

from __future__ import annotations

import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.gateway.bench import Bench, drive, never_enabled
from tests.gateway.test_falls import POSE
from tests.gateway.test_readback import CHECK, PATIENT, RUN, SHORT, refusal


def test_off_ends_torque_that_no_watchdog_ends(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Drives in operation after a crash, one of them energised without a master."""
    for options in (drive(3, 'initial = "enabled"'), drive(3, 'initial = "fault"'), ""):
        ran = Bench(hexapod_ssp, tmp_path).run(options=options, command=("off",))
        assert ran.code == 0, ran.words
        assert ran.one("off")["devices"] == 6
        states = {e["position"]: e["state"] for e in ran.events if e["event"] == "device"}
        assert states[3] == ("fault" if "fault" in options else "switch on disabled")


CRASH = """#!/bin/sh
# runs the gateway, kills it in the cycle, and asks for a check and for `off` on the same cable
"$@" > {folder}/first & pid=$!
until grep -q '"event":"status"' {folder}/first; do sleep 0.05; done
kill -9 $pid; wait $pid
"$1" check "$3" --bus --interface bus1 --ssp {ssp} 2>&1 > {folder}/check
exec "$1" off "$3" --json --interface bus1
"""


def test_off_after_a_crash_without_a_watchdog(hexapod_ssp: Path, tmp_path: Path) -> None:
    """In lockstep no time passes after the crash: six drives stay enabled until `off`."""
    script = tmp_path / "crash.sh"
    script.write_text(CRASH.format(folder=tmp_path, ssp=hexapod_ssp))
    ran = Bench(hexapod_ssp, tmp_path).run(wrapper=("sh", script), seconds=100.0)
    assert ran.code == 0, ran.words
    assert "operation with `flexhex-gateway off`" in (tmp_path / "check").read_text()
    assert ran.one("off")["devices"] == 6
    enabled = [e for e in ran.happened("drive") if e["to"] == "operation enabled"]
    left = [e for e in ran.happened("drive") if e["from"] == "operation enabled"]
    assert len(enabled) == len(left) == 6
    assert not ran.happened("watchdog")


def test_live_machine_needs_its_real_time_rights(hexapod_ssp: Path, tmp_path: Path) -> None:
    """CPU 1023 does not exist; a dry run is no live machine."""
    changes = (("# cpu = 1 ", "cpu = 1023 #"), ("# required = true", "required = true"))
    bench = Bench(hexapod_ssp, tmp_path)
    message = refusal(bench.run(command=("run", "--enable"), changes=changes))
    assert "not pinned to CPU 1023" in message
    assert "real_time.required = false" in message
    ran = bench.run(command=("run", "--dry-run"), changes=(*changes, *PATIENT), seconds=SHORT)
    assert not [e for e in ran.events if e["event"] == "refused"], ran.words


def test_limits_that_cannot_act_are_refused_together(hexapod_ssp: Path, tmp_path: Path) -> None:
    changes = (
        ("position_max_rad = 0.52", "position_max_rad = 0.55"),
        ("jump_rad = 0.001", "jump_rad = 0.0001"),
    )
    ran = Bench(hexapod_ssp, tmp_path).run(command=RUN, changes=changes)
    assert ran.code == 3, ran.words
    message = ran.one("refused")["message"]
    # once for the six axes that share it
    assert message.count("the stroke ends at -0.5235987755982988 and 0.52359") == 1
    assert "limits.jump_rad = 0.0001 is less than 0.00075 rad" in message
    assert not ran.happened("state"), "not one frame was sent"


@pytest.mark.parametrize("others", [[0, 4], [6]])
def test_other_devices_on_the_bus_are_left_in_pre_op(
    others: list[int], hexapod_ssp: Path, tmp_path: Path
) -> None:
    """A terminal before, between or behind the drives; the motion is the same to the last bit."""
    options = f"[drives]\nothers = {others}\n"
    drives = [k for k in range(6 + len(others)) if k not in others]
    # from the last on, as one new position is another's old one
    changes = tuple(
        (f"\nposition = {k}\n", f"\nposition = {drives[k]}\n") for k in range(5, -1, -1)
    )
    bench = Bench(hexapod_ssp, tmp_path)
    assert bench.run(options=options, command=CHECK, changes=changes).code == 0
    ran = bench.run(options=options, changes=changes, seconds=0.25)
    assert ran.code == 0, ran.words
    reached = {e["position"] for e in ran.happened("state") if e["to"] == "OP"}
    assert reached == set(drives)
    alone = bench.run(seconds=0.25)
    assert alone.happened("stopped")[0]["digest"] == ran.happened("stopped")[0]["digest"]
    # a drive that the configuration does not name may not be energised either
    options += drive(others[0], 'initial = "enabled"')
    message = refusal(bench.run(options=options, changes=changes, command=CHECK))
    assert f"position {others[0]}, no drive of the configuration: already energised" in message


def test_recordings_are_never_overwritten(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The second run of a shell script is refused before power; heads tell the settings apart."""
    again = (
        "import subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=2);"
        "sys.exit(subprocess.run(sys.argv[1:]).returncode)"
    )
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(wrapper=(sys.executable, "-c", again), seconds=SHORT)
    assert ran.code == 3, ran.words
    assert (
        "run.csv: File exists (os error 17): recordings are never" in ran.one("refused")["message"]
    )
    assert len(ran.table["time"]) >= 80, "rows of the first run"
    first = head(ran.recording)
    assert abs(datetime.now(UTC) - datetime.fromisoformat(first["date"])) < timedelta(hours=1)
    assert first["version"]
    assert head(bench.run(seconds=SHORT).recording)["config_hash"] == first["config_hash"]
    changed = bench.run(seconds=SHORT, changes=(("speed_cycles = 8", "speed_cycles = 9"),))
    assert head(changed.recording)["config_hash"] != first["config_hash"]


def head(recording: Path) -> dict[str, str]:
    """The lines `# key: value` of a recording."""
    lines = [line[2:] for line in recording.read_text().splitlines() if line.startswith("# ")]
    return {key: value for key, _, value in (line.partition(": ") for line in lines)}


def test_pose_outside_its_limits_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The start of the run lies outside, or nothing has that name."""
    for old, new, why in (
        ("max = 0.315", "max = 0.29", "N_F.x.x_E.z starts at 0.3, allowed 0.28 to 0.29"),
        ("x_E.z", "x_E.w", 'pose[0].signal: the system has no signal "N_F.x.x_E.w"'),
        ("min = 0.28", "min = 0.4", "pose[0].min = 0.4 is not below max = 0.315"),
    ):
        pose = (POSE[0], POSE[1].replace(old, new))
        ran = Bench(hexapod_ssp, tmp_path).run(changes=(pose,), seconds=0.01)
        assert ran.code == 3, ran.words
        assert why in ran.one("refused")["message"]
        never_enabled(ran)


def test_signal_of_another_unit_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    """It is another quantity, and a rule would judge it as this one."""
    for change, said, more in (
        (('feedforward = "F.tau_ff"', 'feedforward = "reference.r"'),
         'system.feedforward: reference.r[1] is in "rad", must be in "N m"', '"F.tau_ff"'),
        (('reference = "reference.r"', 'reference = "reference.rd"'),
         'system.reference: reference.rd[1] is in "rad/s", must be in "rad"', '"reference.r"'),
        (('following_error = "feedback.e"', 'following_error = "feedback.tau"'),
         'system.following_error: feedback.tau[1] is in "N m", must be in "rad"', '"feedback.e"'),
    ):  # fmt: skip
        ran = Bench(hexapod_ssp, tmp_path).run(changes=(change,), command=("check",))
        assert ran.code == 3, ran.words
        message = str(ran.one("refused")["message"])
        assert said in message
        assert more in message
