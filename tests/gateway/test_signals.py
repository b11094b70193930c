"""Signals to the gateway's process at an exact cycle, of a machine with weight."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.alone import kills, paused, stops_for_long
from tests.gateway.bench import Acts, Bench, Process, drive, never_enabled, stops
from tests.gateway.fault_table import Table
from tests.gateway.test_landing import ALL, AT
from tests.gateway.test_refusals import when_said
from tests.gateway.weight import Fallen, free

LIFTING, LANDING = 6000, AT + 1000
"""Cycles since enabling: in the lift-off, and in the landing after a signal at AT."""
APART_S = 0.15
"""Time after which a second Ctrl-C is one [s]: 0.1, and some for the clock."""
NO_TRIGGER = "".join(drive(k, "output_control = 0x24") for k in range(6))


def goes_on(drives: Process) -> None:
    """Continue the drives' process."""
    drives.send_signal(signal.SIGCONT)


def gets(kind: signal.Signals) -> Acts:
    """The gateway gets a signal while it waits for a reply."""

    def act(gateway: Process, drives: Process) -> None:
        gateway.send_signal(kind)
        goes_on(drives)

    return act


@dataclass(frozen=True)
class Stop:
    """A wish to end, the cycle in which it comes, and what is said."""

    name: str
    kind: signal.Signals
    cycle: int = AT


STOPS = (
    Stop("Ctrl-C (SIGINT)", signal.SIGINT),
    Stop("SIGTERM", signal.SIGTERM),
    Stop("closed terminal (SIGHUP)", signal.SIGHUP),
    Stop("Ctrl-C in the lift-off", signal.SIGINT, LIFTING),
    Stop("Ctrl-Z (SIGTSTP)", signal.SIGTSTP),
    Stop("Ctrl-\\ (SIGQUIT)", signal.SIGQUIT),
    Stop("power cut announced (SIGPWR)", signal.SIGPWR),
    Stop("limit of computing time (SIGXCPU)", signal.SIGXCPU),
)


@pytest.mark.sample(2)
@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: stop.name)
def test_signal_lands_the_machine(
    stop: Stop, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    act, cycle = gets(stop.kind), stop.cycle
    fallen = free(Bench(hexapod_ssp, tmp_path), paused(cycle), paused=act, seconds=100.0)
    assert fallen.ran.code == 0, fallen.ran.words
    assert "stopped on request, drives disabled" in fallen.ran.words
    fallen.ends_at_rest(cycle)
    falls.add(fallen.row(stop.name, "none", "land", cycle))


def test_ctrl_c_before_power_is_heeded_at_once(hexapod_ssp: Path, tmp_path: Path) -> None:
    """No drive reaches OP: it would be waited for."""
    options = '[[fault]]\nkind = "frame_lost"\ncycle = 1\ncount = 0\ncounting = "frames"\n'
    patient = ("state_timeout_ms = 5000", "state_timeout_ms = 60000")
    interrupt = when_said('"position":5', lambda pid: os.kill(pid, signal.SIGINT))
    ran = Bench(hexapod_ssp, tmp_path).run(
        options=options, changes=(patient,), command=("run", "--enable"), during=interrupt
    )
    assert ran.code == 0, ran.words
    assert "stopped on request" in ran.words
    never_enabled(ran)


def test_second_request_takes_the_torque_at_once(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    def again(gateway: Process, drives: Process) -> None:
        gets(signal.SIGINT)(gateway, drives)
        assert stops(drives, gateway)
        # the machine waits so long in its landing: the same keystroke passed on would not count
        time.sleep(APART_S)
        gets(signal.SIGINT)(gateway, drives)

    options = paused(AT, LANDING)
    fallen = free(Bench(hexapod_ssp, tmp_path), options, paused=again, seconds=100.0)
    # the torque of the frame that was on its way, and no other
    tau = np.abs(fallen.tau).max(axis=1)
    assert tau[LANDING - 1] > 0.1
    off = {e["cycle"] for e in fallen.ran.happened("torque_zero")}
    assert off <= {LANDING, LANDING + 1}, off
    fallen.ends_at_rest(LANDING)
    falls.add(fallen.row("second Ctrl-C in the landing", "none", "zero", LANDING))


def twice(first: signal.Signals, second: signal.Signals) -> Acts:
    """Both come while the gateway waits for a reply, the second one after the first was taken."""

    def act(gateway: Process, drives: Process) -> None:
        gateway.send_signal(first)
        status = Path(f"/proc/{gateway.pid}/status")
        while pending(status.read_text()):
            time.sleep(0.001)
        gateway.send_signal(second)
        goes_on(drives)

    return act


def pending(status: str) -> bool:
    """A signal waits for the process, in what the kernel says of it."""
    return any(int(line.split()[1], 16) for line in status.splitlines() if "Pnd:" in line)


REPEATED = (
    ("closed terminal, SIGHUP by kernel and shell", signal.SIGHUP, signal.SIGHUP),
    ("power cut announced, then shutdown (SIGPWR, SIGTERM)", signal.SIGPWR, signal.SIGTERM),
)


@pytest.mark.parametrize(("name", "first", "second"), REPEATED)
def test_requests_of_programs_land_however_many_there_are(
    name: str,
    first: signal.Signals,
    second: signal.Signals,
    hexapod_ssp: Path,
    tmp_path: Path,
    falls: Table,
) -> None:
    """Only a person wants the torque off at once."""
    bench, act = Bench(hexapod_ssp, tmp_path), twice(first, second)
    fallen = free(bench, paused(AT), paused=act, seconds=100.0)
    assert fallen.ran.code == 0, fallen.ran.words
    assert "stopped on request, drives disabled" in fallen.ran.words
    assert set(fallen.stopped["drives"]) == {"ready to switch on"}
    fallen.ends_at_rest(AT)
    falls.add(fallen.row(name, "none", "land", AT))


def test_closed_terminal_lands_the_machine(hexapod_ssp: Path, tmp_path: Path, falls: Table) -> None:
    """Nobody reads what the gateway writes any more."""

    def close(gateway: Process, drives: Process) -> None:
        assert gateway.stderr is not None
        gateway.stderr.close()
        gateway.stderr = None
        gets(signal.SIGHUP)(gateway, drives)

    fallen = free(Bench(hexapod_ssp, tmp_path), paused(AT), paused=close, seconds=100.0)
    assert fallen.ran.code == 0
    assert fallen.ran.one("summary")["not_disabled"] == []
    fallen.ends_at_rest(AT)
    falls.add(fallen.row("nobody reads the output any more", "none", "land", AT))


def watchdogs(fallen: Fallen, since: int, cycles: int) -> int:
    """The gateway is gone: all watchdogs act, the windings brake. Cycles to zero torque."""
    assert {e["position"] for e in fallen.ran.happened("watchdog")} == {0, 1, 2, 3, 4, 5}
    after = {e["cycle"] - since for e in fallen.ran.happened("torque_zero")}
    assert len(after) == 1
    (watchdog,) = after
    assert watchdog in range(cycles - 1, cycles + 2)
    fallen.ends_at_rest(since)
    return int(watchdog)


@dataclass(frozen=True)
class Killed:
    """A gateway that ends at once, the drives' watchdog [ms], and when."""

    name: str
    watchdog: int = 5
    options: str = ""
    cycle: int = AT


KILLED = (
    Killed("gateway killed (SIGKILL), watchdog 5 ms"),
    Killed("gateway killed, watchdog 20 ms", 20),
    Killed("gateway killed, no watchdog trigger in the EEPROM (0x24)", options=NO_TRIGGER),
    Killed("gateway killed in the lift-off", cycle=LIFTING),
)


@pytest.mark.sample(2)
@pytest.mark.parametrize("killed", KILLED, ids=lambda killed: killed.name)
def test_killed_gateway_falls_braked(
    killed: Killed, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    cycle, changes = killed.cycle, (("watchdog_ms = 5 ", f"watchdog_ms = {killed.watchdog} "),)
    bench, options = Bench(hexapod_ssp, tmp_path), paused(cycle) + killed.options
    fallen = free(bench, options, changes=changes, paused=kills(bench), seconds=100.0)
    assert fallen.ran.code == -signal.SIGKILL
    cycles = watchdogs(fallen, cycle, killed.watchdog * 4)
    row = fallen.row(
        killed.name, "watchdog of the drives", "zero", cycle, cycles=cycles, unknown=ALL
    )
    falls.add(row)


def test_stopped_gateway_trips_when_it_goes_on_and_reads_the_drives_back(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """Longer than the drives wait."""
    bench = Bench(hexapod_ssp, tmp_path)
    fallen = free(bench, paused(AT), paused=stops_for_long(bench), seconds=100.0)
    trip = fallen.ran.one("trip")
    assert (trip["reason"], trip["reaction"], trip["cycles_to_zero"]) == ("al_state", "zero", 1)
    assert fallen.ran.one("summary")["not_disabled"] == []
    watchdogs(fallen, AT, 20)
    falls.add(fallen.row("gateway stopped and continued later (SIGSTOP)", "al_state", "zero", AT))
