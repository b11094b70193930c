"""A cable for one test: two network namespaces and a veth pair."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Cable:
    """Names of the two ends; `drives` and `gateway` are namespaces."""

    drives: str
    gateway: str

    def at(self, place: str, command: Sequence[object]) -> list[str]:
        """The command in one of the namespaces."""
        return ["ip", "netns", "exec", place, *map(str, command)]


@contextmanager
def cable() -> Iterator[Cable]:
    """A cable of its own for one test; skips where that is not allowed."""
    if shutil.which("ip") is None or os.geteuid() != 0:
        pytest.skip("network namespaces need root and `ip`")
    name = f"fx{os.getpid()}"
    ends = Cable(f"{name}d", f"{name}g")
    try:
        for namespace in (ends.drives, ends.gateway):
            _ip("netns", "add", namespace)
        _ip("link", "add", "bus0", "netns", ends.drives, "type", "veth",
            "peer", "name", "bus1", "netns", ends.gateway)  # fmt: skip
        _ip("-n", ends.drives, "link", "set", "bus0", "up")
        _ip("-n", ends.gateway, "link", "set", "bus1", "up")
        yield ends
    finally:
        for namespace in (ends.drives, ends.gateway):
            subprocess.run(["ip", "netns", "del", namespace], capture_output=True)


def _ip(*words: str) -> None:
    done = subprocess.run(["ip", *words], capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"ip {' '.join(words)}: {done.stderr.strip()}")
