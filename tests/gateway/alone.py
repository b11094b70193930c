"""A gateway that is gone, for ever or for a while, at an exact cycle."""

from __future__ import annotations

import signal
import time

from tests.gateway.bench import LIMIT_S, Acts, Bench, Process


def paused(*cycles: int) -> str:
    """The drives' process stands still in these cycles, until something continues it."""
    return "".join(f'[[fault]]\nkind = "pause"\ncycle = {cycle}\n' for cycle in cycles)


def left_alone(drives: Process, bench: Bench) -> None:
    """The plant goes on without frames until no drive has torque."""
    drives.send_signal(signal.SIGCONT)
    drives.send_signal(signal.SIGUSR1)
    end = time.monotonic() + LIMIT_S
    while '"event":"silence"' not in bench.drives_file.read_text():
        assert drives.poll() is None, "the drives' process has ended"
        assert time.monotonic() < end, "the drives have no torque, or do not go on"
        time.sleep(0.01)


def kills(bench: Bench) -> Acts:
    """Ends the gateway without an orderly shutdown, while it waits for a reply."""

    def act(gateway: Process, drives: Process) -> None:
        gateway.kill()
        gateway.wait()
        left_alone(drives, bench)

    return act


def stops_for_long(bench: Bench) -> Acts:
    """Stops the gateway for longer than the drives wait, and continues it."""

    def act(gateway: Process, drives: Process) -> None:
        gateway.send_signal(signal.SIGSTOP)
        left_alone(drives, bench)
        gateway.send_signal(signal.SIGCONT)

    return act
