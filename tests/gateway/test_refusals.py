"""What the gateway refuses before power, and what the drives do after the gateway ends."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from flexhex.ssp.fmu import binary_path
from flexhex.ssp.read import read_ssp
from tests.gateway.alone import kills, paused, stops_for_long
from tests.gateway.archives import changed, with_fmu
from tests.gateway.bench import Bench, drive, never_enabled
from tests.gateway.fault_table import Row, Table
from tests.gateway.weight import free

RUN = ("run", "--enable", "--lockstep")
CHECK = ("check", "--bus")


BAD = {
    "a drive is missing": ("drives.count = 5\n", "5 devices on the bus"),
    "drives are swapped": (
        drive(0, "serial = 1002") + drive(1, "serial = 1001"),
        "axis 1, position 0: serial is 0x3ea",
    ),
    "a drive of another product": (drive(3, "product = 99"), "axis 4, position 3: product is 0x63"),
    "a drive of another vendor": (drive(3, "vendor = 7"), "axis 4, position 3: vendor is 0x7"),
    "a drive already energised": (drive(2, 'initial = "enabled"'), "position 2: already energised"),
    "a drive with a fault": (drive(5, 'initial = "fault"'), "axis 6, position 5: fault 0x7305"),
}  # fmt: skip
ONLY_RUN = {
    "PDO maps that cannot be written": (drive(1, "maps_fixed = true"), "object 0x1c12"),
    "process data of another size": (
        drive(1, "extra_input_bytes = 2"),
        "position 1: AL status code 0x001e",
    ),
    "an angle outside its limits": (drive(4, "offset = -500000000"), "axis 5: theta = -0.98"),
    "an angle far from the rest pose": (
        drive(4, "offset = 50000000"),
        "landing.rest_rad = -0.25 rad",
    ),
}


REST_RAD = "# rest_rad = [-0.34, -0.35, -0.34, -0.37, -0.35, -0.37]"
RESTS = (REST_RAD, "rest_rad = [-0.24, -0.35, -0.23, -0.29, -0.25, -0.32]")
"""Where the machine rests without torque."""
REST = (REST_RAD, "rest_rad = [0, 0, 0, 0, 0, 0]")


def serials(position: int) -> tuple[str, str]:
    """The template's serial number, as an expectation."""
    return (f"# serial = {1001 + position}", f"serial = {1001 + position}")


@pytest.mark.sample(6)
@pytest.mark.parametrize("name", [*BAD, *ONLY_RUN])
def test_wrong_bus_is_refused_before_power(
    name: str, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    options, wanted = (BAD | ONLY_RUN)[name]
    changes = tuple(serials(k) for k in (0, 1)) if "swapped" in name else ()
    changes += (RESTS,) if "rest pose" in name else ()
    bench = Bench(hexapod_ssp, tmp_path)
    for command in (CHECK, RUN) if name in BAD else (RUN,):
        fallen = free(bench, options, changes=changes, command=command)
        ran = fallen.ran
        assert ran.code == 1, ran.words
        assert wanted in ran.one("refused")["message"]
        never_enabled(ran)
        # with rows of the enabling it stays
        assert not ran.recording.exists() or len(ran.table["time"]), "its name may be used again"
    falls.add(fallen.refused(name))


def test_good_bus_passes_the_check(hexapod_ssp: Path, tmp_path: Path) -> None:
    changes = (("# cpu = 1 ", "cpu = 1023 #"),)
    ran = Bench(hexapod_ssp, tmp_path).run(command=CHECK, changes=changes)
    assert ran.code == 0, ran.words
    # what this computer cannot give is told, and is no reason to refuse
    assert "not pinned to CPU 1023" in ran.words
    never_enabled(ran)


def test_faults_are_reset_only_when_asked(hexapod_ssp: Path, tmp_path: Path) -> None:
    options = drive(5, 'initial = "fault"')
    ran = Bench(hexapod_ssp, tmp_path).run(
        options=options, command=(*RUN, "--reset-faults"), seconds=0.05
    )
    assert ran.code == 0, ran.words


def test_nothing_is_enabled_without_being_asked(hexapod_ssp: Path, tmp_path: Path) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(command=("run", "--lockstep"))
    assert ran.code == 2
    never_enabled(ran)


def test_fmu_of_another_platform_is_bad_input(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    model = read_ssp(hexapod_ssp).instance("feedback").fmu.model
    data, source = hexapod_ssp.read_bytes(), "resources/feedback.fmu"
    bad = tmp_path / "bad.ssp"
    bad.write_bytes(with_fmu(data, source, {binary_path(model): None, "binaries/other/f.so": b""}))
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, command=RUN)
    assert ran.code == 3, ran.words
    message = ran.one("refused")["message"]
    assert "feedback" in message
    assert "other" in message
    table.add(Row("FMU without a binary for this platform", "refused", "no power", None, None))


def test_system_without_the_wanted_component_is_bad_input(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    for old, new, wanted in (
        ('host = "plant"', 'host = "machine"', "no component"),
        ('"feedback.e"', '"feedback.error"', "system.following_error"),
        ('["K"]', '["E"]', "system.own_thread"),
        ("{ feedback =", "{ feedbeck =", "safety.non_trip_faults"),
        ("reply_timeout_us = 200", "reply_timeout_us = 300", "allowed less than 250"),
        ("torque_N_m = 27.0", "torque_N_m = 5.0", "feedback.tau_max = 27"),
    ):
        ran = Bench(hexapod_ssp, tmp_path).run(command=RUN, changes=((old, new),))
        assert ran.code == 3, ran.words
        assert wanted in ran.one("refused")["message"]
        assert not ran.happened("state"), "not one frame was sent"
    table.add(Row("system and configuration do not match", "refused", "no power", None, None))


@pytest.mark.parametrize(
    ("member", "data", "wanted"),
    [
        ("SystemStructure.ssd", None, "SystemStructure.ssd"),
        ("resources/feedback.fmu", None, "feedback"),
        ("resources/feedback.fmu", b"rubbish", "feedback"),
    ],
)
def test_system_that_does_not_fit_is_bad_input(
    member: str, data: bytes | None, wanted: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    bad = tmp_path / "bad.ssp"
    bad.write_bytes(changed(hexapod_ssp.read_bytes(), {member: data}))
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, command=RUN)
    assert ran.code == 3, ran.words
    assert wanted in ran.one("refused")["message"]
    assert not ran.happened("state"), "not one frame was sent"


def test_full_disk_is_reported_and_does_not_stop_the_machine(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(record=Path("/dev/full"), seconds=2.5)
    assert ran.code == 1
    summary = ran.one("summary")
    assert summary["cycles"] == 10_000
    assert summary["cycles_to_disabled"] is not None
    assert "/dev/full" in ran.one("refused")["message"]


def when_running(act: Callable[[int], None]) -> Callable[[subprocess.Popen[str]], None]:
    """Acts on the gateway's process after its first status event."""
    return when_said('"event":"status"', act)


def when_said(text: str, act: Callable[[int], None]) -> Callable[[subprocess.Popen[str]], None]:
    """Acts on the gateway's process after the first event with this text."""

    def wait(gateway: subprocess.Popen[str]) -> None:
        assert gateway.stdout is not None
        for line in gateway.stdout:
            if text in line:
                act(gateway.pid)
                return

    return wait


RUNS = 1000
"""A cycle of the controller."""


def test_killed_gateway_leaves_it_to_the_watchdog(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=paused(RUNS), seconds=100.0, paused=kills(bench))
    assert ran.code == -signal.SIGKILL
    expired = ran.happened("watchdog")
    zero = ran.happened("torque_zero")
    silence = ran.happened("silence")[0]["cycle"]
    assert len(expired) == len(zero) == 6
    # 5 ms are 20 cycles after the last frame; the plant stood still until it was missed
    assert {e["cycle"] - silence for e in zero} <= {19, 20, 21}
    table.add(Row("gateway killed", "watchdog of the drives", "zero", 20, 5.0))


def test_gateway_that_was_stopped_trips_when_it_goes_on(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=paused(RUNS), seconds=100.0, paused=stops_for_long(bench))
    trip = ran.one("trip")
    assert (ran.code, trip["reason"], trip["cycles_to_zero"]) == (1, "al_state", 1)
    assert len(ran.happened("watchdog")) == len(ran.happened("torque_zero")) == 6
    table.add(Row("gateway stopped and continued", "al_state", "zero", 0, None))


def test_ctrl_c_ends_in_order(hexapod_ssp: Path, tmp_path: Path) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(
        seconds=100.0,
        during=when_running(lambda pid: os.kill(pid, signal.SIGINT)),
    )
    assert ran.code == 0, ran.words
    last = {e["position"]: e for e in ran.happened("drive")}
    assert all(e["to"] != "operation enabled" and e["error"] == 0 for e in last.values())
    # a device that stayed in OP would miss its frames
    left = {e["position"]: e["to"] for e in ran.happened("state")}
    assert len(left) == 6
    assert "OP" not in left.values()
