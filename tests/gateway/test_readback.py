"""Values of the drives, compared before power: refused when wrong, accepted when right."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.gateway.alone import kills, paused
from tests.gateway.bench import Bench, Ran, drive, never_enabled
from tests.gateway.fault_table import Table
from tests.gateway.test_refusals import REST, RUNS
from tests.gateway.weight import free

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
    "torque constant": (
        drive(2, "objects = [{ object = 0x6075, bits = 32, value = 4243 }]"),
        "torque constant 0x6076 / 0x6075 is 2.121 N m/A, expected 3 N m/A",
        "profile.unchecked = [0x6075]",
    ),
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
    name: str, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    options, wanted, mend = (BY_CHECK | BY_RUN)[name]
    for command in (CHECK, RUN) if name in BY_CHECK else (RUN,):
        fallen = free(Bench(hexapod_ssp, tmp_path), options, command=command)
        message = refusal(fallen.ran)
        assert wanted in message
        assert mend in message
        assert message.count("axis 3") == len(message.splitlines()) == 1, (
            "the other drives are right"
        )
    falls.add(fallen.refused(f"wrong value of a drive: {name}"))


def test_values_that_are_right_are_accepted(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Also those that the gateway sets by itself, and objects that a drive may lack."""
    absent = ", ".join(
        f'{{ object = {o}, sub = {s}, access = "absent" }}'
        for o, s in [(0x6091, 1), (0x607E, 0), (0x60C2, 1), (0x605D, 0), (0x6075, 0)]
    )
    options = drive(1, "output_control = 0x24") + drive(2, f"objects = [{absent}]")
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, seconds=SHORT)
    assert ran.code == 0, ran.words


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (an_object(0x6075, access="absent"), "rated current 0x6075 is not in the drive"),
        (an_object(0x6076, access="absent"), "rated torque 0x6076 is not in the drive"),
        (
            drive(2, "objects = [{ object = 0x6075, bits = 32, value = 0 }]"),
            "rated current 0x6075 is 0",
        ),
    ],
    ids=["no current", "no torque", "not set"],
)
def test_check_says_where_the_torque_constant_is_not_compared(
    options: str, why: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, command=CHECK)
    assert ran.code == 0, ran.words
    note = ran.one("uncompared")
    assert (note["axis"], note["position"]) == (3, 2)
    assert f"torque constant not compared, {why}: compare " in str(note["message"])
    assert "`calibrate torque` measures it" in ran.words


def test_unchecked_objects_are_not_compared(hexapod_ssp: Path, tmp_path: Path) -> None:
    change = ("# unchecked = [0x608F]", "unchecked = [0x608F]")
    options = an_object(0x608F, sub=1, access="absent")
    # without the scale the pose must be known: here something holds it at zero
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, changes=(change, REST), seconds=SHORT)
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
    options = paused(RUNS) + "".join(drive(k, "output_control = 0x24") for k in range(6))
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=options, seconds=100.0, paused=kills(bench))
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


def test_drives_that_keep_another_synchronisation_are_refused(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """With SYNC0 only: lockstep has no clock."""
    options = an_object(0x1C32, 1, 1, "stuck")
    bench = Bench(hexapod_ssp, tmp_path)
    message = refusal(bench.run(options=options, command=("run", "--dry-run"), changes=PATIENT))
    wanted = "axis 3, position 2: 0x1c32:1 (synchronisation type, 2: SYNC0) is 1, expected 2"
    assert message.startswith(wanted)
    assert bench.run(options=options, seconds=SHORT).code == 0


def test_mode_that_changes_in_the_run_trips(hexapod_ssp: Path, tmp_path: Path) -> None:
    fault = '[[fault]]\nkind = "mode_change"\ncycle = 400\nposition = 4\nsize = 8\n'
    ran = Bench(hexapod_ssp, tmp_path).run(options=fault, seconds=1.0)
    trip = ran.one("trip")
    assert (ran.code, trip["reason"], trip["axis"]) == (1, "mode", 5)
    assert (trip["value"], trip["limit"]) == (8, 4)
