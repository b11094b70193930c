"""An independent decoder (tshark) of the frames on a cable."""

from __future__ import annotations

import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.gateway.cable import Cable

LIMIT_S = 60
"""A decoder that hangs is ended after this; nothing is measured with it."""


def need_tshark() -> None:
    """Skips without the independent decoder."""
    if shutil.which("tshark") is None:
        pytest.skip("no tshark: apt-get install tshark")


def decode(capture: Path, *words: str) -> list[str]:
    """Lines of tshark for a capture."""
    command = ["tshark", "-n", "-r", str(capture), *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def malformed(capture: Path) -> list[str]:
    """Frames that tshark calls malformed, or whose dissection it reports an error for."""
    return decode(capture, "-Y", "_ws.malformed || _ws.expert.severity == error")


def written(file: Path) -> None:
    """Waits until no more frames arrive: a capture drops unread frames when it is stopped."""
    size = -1
    for _ in range(LIMIT_S):
        before, size = size, file.stat().st_size
        if size == before:
            return
        time.sleep(1.0)


@contextmanager
def capturing(ends: Cable, file: Path) -> Iterator[None]:
    """Records all that passes at the master's end of the cable."""
    need_tshark()
    words = ["tshark", "-n", "-q", "-B", "64", "-i", "bus1", "-w", file]
    command = ends.at(ends.gateway, words)
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    # its file gets a head when the interface is open; "Capturing on" comes too early
    while process.poll() is None and not (file.exists() and file.stat().st_size):
        time.sleep(0.02)
    try:
        yield
    finally:
        written(file)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=LIMIT_S)
