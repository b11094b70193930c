"""Ctrl-C from the start of the gateway to a machine that lifts off, at any frame."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from tests.gateway.bench import Bench, Process, Ran, drive, never_enabled
from tests.gateway.test_signals import gets

FIRST = 3590
"""Frame of any kind about which the bring-up is over and the process data begin."""
FRAMES = (1, 5, 100, *range(400, FIRST, 450), *range(FIRST, FIRST + 45, 3), 4000)
SHELL = ("sh", "-c", 'trap "" INT; exec "$@"', "sh")
BLOCKED = "import os, signal, sys; signal.pthread_sigmask(signal.SIG_BLOCK, [2])"
STARTERS = {
    "ignored": SHELL,
    "blocked": (sys.executable, "-c", f"{BLOCKED}; os.execvp(sys.argv[1], sys.argv[1:])"),
}


def at_frame(frame: int) -> str:
    """The drives' process stands still before it answers this frame of any kind."""
    return f'[[fault]]\nkind = "pause"\ncounting = "any_frames"\ncycle = {frame}\n'


@contextmanager
def opened(pipe: Path, gateway: Process) -> Iterator[None]:
    """The gateway reads from a named pipe meanwhile; it must not end before."""
    end = None
    while end is None:
        assert gateway.poll() is None, gateway.communicate()
        with suppress(OSError):
            end = os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
    yield
    os.close(end)


def harmless(ran: Ran) -> None:
    """No drive has power or an error, no watchdog has acted, and all devices are in INIT."""
    last = {e["position"]: e for e in ran.happened("drive")}
    on = [e for e in last.values() if e["to"] == "operation enabled" or e["error"] != 0]
    assert not on, f"exit code {ran.code}, {on}\n{ran.words}"
    assert not ran.happened("watchdog")
    layers = {e["position"]: e["to"] for e in ran.happened("state")}
    assert set(layers.values()) <= {"INIT"}, layers


@pytest.mark.sample(8)
@pytest.mark.parametrize("frame", FRAMES)
def test_ctrl_c_at_any_frame_leaves_the_drives_disabled(
    frame: int, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Bringing up, enabling or lifting off."""
    bench, act = Bench(hexapod_ssp, tmp_path), gets(signal.SIGINT)
    ran = bench.run(options=at_frame(frame), seconds=100.0, paused=act)
    assert ran.code == 0, ran.words
    assert "stopped on request" in ran.words
    harmless(ran)


def test_ctrl_c_at_once_only_ends_the_process(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Before it has sent anything, or soon after: both are good."""
    ran = Bench(hexapod_ssp, tmp_path).run(
        seconds=100.0, during=lambda gateway: gateway.send_signal(signal.SIGINT)
    )
    assert ran.code in (0, -signal.SIGINT), ran.words
    harmless(ran)


@pytest.mark.parametrize("starter", STARTERS)
def test_ctrl_c_counts_from_the_start_whatever_the_starter_ignores(
    starter: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """A shell ignores it in what it starts in the background: the machine would be enabled."""
    learned = tmp_path / "learned.json"
    os.mkfifo(learned)

    def while_it_reads(gateway: Process) -> None:
        with opened(learned, gateway):
            gateway.send_signal(signal.SIGINT)

    command = ("run", "--enable", "--lockstep", "--resume", learned)
    ran = Bench(hexapod_ssp, tmp_path).run(
        command=command, wrapper=STARTERS[starter], during=while_it_reads
    )
    assert ran.code == -signal.SIGINT, ran.words
    assert not ran.happened("state")


def test_ctrl_c_counts_while_replies_are_incomplete(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The drives are being enabled; one takes no part, which is borne for long here."""
    borne = [("working_counter_limit = 3", "working_counter_limit = 1000")]
    short = 'kind = "wkc_short"\ncounting = "frames"\ncycle = 17\ncount = 0\nposition = 2\n'
    options = f"[[fault]]\n{short}" + at_frame(FIRST + 60)
    ran = Bench(hexapod_ssp, tmp_path).run(
        options=options, changes=borne, paused=gets(signal.SIGINT)
    )
    assert ran.code == 0, ran.words
    assert "stopped on request" in ran.words
    # its own watchdog has acted, as nothing reached it
    assert {e["position"] for e in ran.happened("watchdog")} == {2}
    never_enabled(ran)


def test_refused_bring_up_leaves_all_devices_in_init(hexapod_ssp: Path, tmp_path: Path) -> None:
    """In OP, where the watchdogs run, and before it."""
    for options in (drive(4, "forced_mode = 8"), drive(1, "maps_fixed = true")):
        ran = Bench(hexapod_ssp, tmp_path).run(options=options)
        assert ran.code == 1, ran.words
        assert ran.happened("state")
        harmless(ran)


def test_off_is_not_ended_between_two_drives(hexapod_ssp: Path, tmp_path: Path) -> None:
    options = drive(3, 'initial = "enabled"') + at_frame(60)
    ran = Bench(hexapod_ssp, tmp_path).run(
        options=options, command=("off",), paused=gets(signal.SIGINT)
    )
    assert ran.happened("fault"), "it had begun"
    assert ran.code == 0, ran.words
    harmless(ran)
    (left,) = [e for e in ran.happened("drive") if e["from"] == "operation enabled"]
    assert left["position"] == 3


def test_gateway_under_test_heeds_ctrl_c() -> None:
    """Also where the tests were started in the background: what they start would ignore it."""
    status = subprocess.run(["grep", "SigIgn", "/proc/self/status"], capture_output=True, text=True)
    ignored = int(status.stdout.split()[1], 16)
    assert not ignored >> (signal.SIGINT - 1) & 1
