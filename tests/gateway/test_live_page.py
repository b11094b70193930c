"""The live page of a run, in a browser beside the gateway."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tests.flexhex.browser import Browser
from tests.gateway.bench import Bench
from tests.gateway.test_refusals import when_running
from tests.gateway.test_status import PORT, UP

CELLS = "[...document.querySelectorAll('tbody tr')].map(r => [...r.cells].map(c => c.textContent))"
TEXT = "[get('phase').textContent, get('counts').textContent]"
COLOURS = ((0x2A, 0x7A, 0xB8), (0xC0, 0x39, 0x2B))
"""Of the axes 1 and 4 in the plots."""


@contextmanager
def network_of(pid: int) -> Iterator[None]:
    """What is started meanwhile is in the network of that process."""
    with Path("/proc/thread-self/ns/net").open() as ours, Path(f"/proc/{pid}/ns/net").open() as its:
        enter(its.fileno())
        try:
            yield
        finally:
            enter(ours.fileno())


def enter(network: int) -> None:
    """This thread, and what it starts, is in that network (setns(2); in Python from 3.12 on)."""
    if ctypes.CDLL(None, use_errno=True).setns(network, 0) != 0:
        raise OSError(ctypes.get_errno(), "setns")


def test_page_shows_the_run_while_it_goes_on(hexapod_ssp: Path, tmp_path: Path) -> None:
    seen: dict[str, Any] = {}

    def look(pid: int) -> None:
        with network_of(pid):
            browser = Browser(tmp_path / "profile")
        try:
            browser.open(f"http://127.0.0.1:{PORT}/", 1100, 900)
            seen["first"] = browser.run(TEXT)
            time.sleep(1.0)
            seen["second"] = browser.run(TEXT)
            seen["cells"], picture = browser.run(CELLS), browser.picture()
            seen["said"], seen["asked"] = list(browser.said), set(browser.requests)
            # the page itself allows no images
            browser.call("Page.navigate", url="about:blank")
            seen["pixels"] = browser.unpacked(picture)
            (tmp_path / "page.png").write_bytes(picture)
        finally:
            browser.close()
            os.kill(pid, signal.SIGINT)

    def during(gateway: subprocess.Popen[str]) -> None:
        when_running(look)(gateway)

    command = ("run", "--enable", "--lockstep", "--page", PORT)
    ran = Bench(hexapod_ssp, tmp_path).run(
        seconds=1000.0, command=command, wrapper=UP, during=during
    )
    assert ran.code == 0, ran.words
    times = [
        float(seen[name][0].removeprefix("running, ").removesuffix(" s"))
        for name in ("first", "second")
    ]
    assert times[1] > times[0], "it goes on"
    assert "0 replies lost" in seen["second"][1]
    assert [row[0] for row in seen["cells"]] == list("123456")
    assert all(row[6] == "operation enabled" for row in seen["cells"])
    # every cell is a value of the recording
    theta = np.round(ran.table["theta"][:, 3], 5)
    assert float(seen["cells"][3][1]) in theta
    for colour in COLOURS:
        near = np.abs(seen["pixels"] - np.array(colour)).max(axis=2) < 30
        assert np.count_nonzero(near) > 50, "the axis is drawn"
    assert seen["said"] == []
    assert all(address.startswith(f"http://127.0.0.1:{PORT}/") for address in seen["asked"])
