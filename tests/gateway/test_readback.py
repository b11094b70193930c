"""Values of the drives, compared before power: refused when wrong, accepted when right."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.gateway.bench import Bench, Ran, drive, never_enabled
from tests.gateway.test_refusals import kill, when_running

RUN = ("run", "--enable", "--lockstep")
CHECK = ("check", "--bus")
SHORT = 0.02
PATIENT = (
    ("watchdog_ms = 5 ", "watchdog_ms = 1000 #"),
    ("overrun_us = 2000", "overrun_us = 900000"),
)
"""For runs by the clock on a busy computer."""


def an_object(index: int, value: int = 0, sub: int = 0, access: str = "writable") -> str:
    """Options of drive 2 (axis 3) with another object."""
    entry = f'{{ object = {index}, sub = {sub}, value = {value}, access = "{access}" }}'
    return drive(2, f"objects = [{entry}]")


def refusal(ran: Ran) -> str:
    """The message of a run that was refused without power."""
    assert ran.code == 1, ran.words
    never_enabled(ran)
    return str(ran.one("refused")["message"])


BY_CHECK = {
    "encoder scale": (
        drive(2, "counts_per_rev = 1048576.0"),
        "axis 3, position 2: counts of one revolution 0x608f is 1048576, expected 4294967296",
        "FB1.PSCALE",
    ),
    "encoder scale not there": (
        an_object(0x608F, sub=1, access="absent"),
        "0x608f is not in the drive, expected 4294967296",
        "profile.unchecked = [0x608F]",
    ),
    "gear": (an_object(0x6091, 5, 1), "gear ratio 0x6091 is 5:1, expected 1:1", "set 1:1"),
    "polarity": (an_object(0x607E, 0x80), "polarity 0x607e is 0x80, expected 0x00", "drive.direc"),
}
"""Options of the emulator, value and expected value, remedy; each of one drive."""

BY_RUN = {
    "watchdog trigger cannot be set": (
        drive(2, "output_control = 0x24\ntrigger_fixed = true"),
        "watchdog trigger (bit 6 of register 0x0814) is 0 (0x24), expected 1 (0x64)",
        "correct its EEPROM",
    ),
    "watchdog does not run": (
        drive(2, "watchdog_dead = true"),
        "watchdog status (bit 0 of register 0x0440) is 0, expected 1",
        "replace the drive",
    ),
    "another mode than set": (
        drive(2, "forced_mode = 8"),
        "mode of operation display 0x6061 is 8, expected 4",
        "compare profile.mode",
    ),
    "reaction to faults": (
        an_object(0x605E, 0, access="stuck"),
        "0x605e:0 (fault: quick-stop ramp) is 0, expected 2",
        "holds another value",
    ),
    "quick stop": (
        an_object(0x605A, 6, access="read_only"),
        "0x605a:0 (quick stop: ramp, then disabled) is 6, expected 2",
        "correct the start-up list",
    ),
    "cycle time": (
        an_object(0x60C2, 2, 1, "stuck"),
        "0x60c2:1 (cycle time) is 2, expected 25",
        "compare with its manual",
    ),
}  # fmt: skip


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", [*BY_CHECK, *BY_RUN])
def test_wrong_value_of_a_drive_is_refused_with_the_expected_one(
    name: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    options, wanted, mend = (BY_CHECK | BY_RUN)[name]
    for command in (RUN, CHECK) if name in BY_CHECK else (RUN,):
        message = refusal(Bench(hexapod_ssp, tmp_path).run(options=options, command=command))
        assert wanted in message
        assert mend in message
        assert message.count("axis 3") == len(message.splitlines()) == 1, (
            "the other drives are right"
        )


def test_values_that_are_right_are_accepted(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Also those that the gateway sets by itself, and objects that a drive may lack."""
    absent = ", ".join(
        f'{{ object = {o}, sub = {s}, access = "absent" }}'
        for o, s in [(0x6091, 1), (0x607E, 0), (0x60C2, 1), (0x605D, 0)]
    )
    options = drive(1, "output_control = 0x24") + drive(2, f"objects = [{absent}]")
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, seconds=SHORT)
    assert ran.code == 0, ran.words


def test_unchecked_objects_are_not_compared(hexapod_ssp: Path, tmp_path: Path) -> None:
    change = ("# unchecked = [0x608F]", "unchecked = [0x608F]")
    options = an_object(0x608F, sub=1, access="absent")
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, changes=(change,), seconds=SHORT)
    assert ran.code == 0, ran.words


def test_rated_torque_and_modes_of_a_cia402_drive(hexapod_ssp: Path, tmp_path: Path) -> None:
    bench = Bench(hexapod_ssp, tmp_path, "cia402")
    options = "[drives]\nrated_torque_mnm = 5000\n"
    message = refusal(bench.run(options=options, command=CHECK))
    assert message.count("rated torque 0x6076 is 5000 mN m, expected 9000 mN m: set ") == 6
    message = refusal(bench.run(changes=(("mode = 10 ", "mode = 4 #"),), command=CHECK))
    assert "supported modes 0x6502 is 0x00000380, expected 0x00000008 among them" in message


def test_without_the_trigger_in_its_eeprom_the_watchdog_still_acts(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """The gateway sets the bit, so a killed gateway leaves no torque."""
    options = "silence_s = 0.3\n" + "".join(drive(k, "output_control = 0x24") for k in range(6))
    ran = Bench(hexapod_ssp, tmp_path).run(
        options=options, seconds=100.0, during=when_running(kill), linger=1.0
    )
    assert ran.code == -signal.SIGKILL
    assert len(ran.happened("watchdog")) == len(ran.happened("torque_zero")) == 6


def test_a_drive_that_wants_its_cycle_time_gets_it(hexapod_ssp: Path, tmp_path: Path) -> None:
    """By the clock, as only SYNC0 has a period; the status code is told in words."""
    clock = ("run", "--dry-run")
    options = "".join(drive(k, "period_checked = true") for k in range(6))
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=options, command=clock, seconds=SHORT, changes=PATIENT)
    assert not [e for e in ran.events if e["event"] == "refused"], ran.words
    changes = (*PATIENT, ("# unchecked = [0x608F]", "unchecked = [0x60C2]"))
    ran = bench.run(options=options, command=clock, seconds=SHORT, changes=changes)
    message = refusal(ran)
    assert "AL status code 0x0035 (invalid cycle time of SYNC0): the drive does not" in message


def test_start_up_lists_are_shown_written_and_stored(hexapod_ssp: Path, tmp_path: Path) -> None:
    own = (
        "position = 2\n",
        'position = 2\nstartup = [{ object = 0x605A, type = "i16", value = 6 }]\n',
    )
    options = an_object(0x605E, 0)
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=options, command=(*CHECK, "--diff"), changes=(own,))
    assert ran.code == 0, ran.words
    shown = {(e["axis"], e["what"].split()[0]): e for e in ran.events if e["event"] == "difference"}
    assert shown[3, "0x605e:0"]["actual"] == "0"
    assert shown[3, "0x605e:0"]["expected"] == "2"
    assert shown[3, "0x605a:0"]["expected"] == "6", "the list of the drive itself comes first"
    assert (1, "0x605e:0") not in shown
    assert not ran.happened("stored")
    ran = bench.run(options=options, command=(*CHECK, "--write"), changes=(own,))
    assert ran.code == 0, ran.words
    assert [e["position"] for e in ran.happened("stored")] == [0, 1, 2, 3, 4, 5]
    never_enabled(ran)


def test_mode_that_changes_in_the_run_trips(hexapod_ssp: Path, tmp_path: Path) -> None:
    fault = '[[fault]]\nkind = "mode_change"\ncycle = 400\nposition = 4\nsize = 8\n'
    ran = Bench(hexapod_ssp, tmp_path).run(options=fault, seconds=1.0)
    trip = ran.one("trip")
    assert (ran.code, trip["reason"], trip["axis"]) == (1, "mode", 5)
    assert (trip["value"], trip["limit"]) == (8, 4)


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
    assert message.count("the stroke ends at -0.5235987755982988 and 0.52359") == 6
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
