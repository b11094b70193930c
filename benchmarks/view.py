"""Time until a person sees: the page of `flexhex view` with ten minutes at 4 kHz, in Chromium on a
computer without a graphics card, by the clock."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from benchmarks.clock import Row, Timing
from flexhex.compare.runs import named_runs
from flexhex.fmus.common.errors import RunError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.view.data import page_data
from flexhex.view.page import write_view
from tests.flexhex.browser import NAMES, Browser
from tests.flexhex.test_view import run_of

SECONDS, INSTANTS = 600.0, 120
OPEN, SCRUB = 3.0, 1 / 60
"""Longest time to open [s]; to show another instant [s], a picture of a screen."""
DRAWN = (
    f"Array.from({{ length: {INSTANTS} }}, (_, k) => {{ const began = performance.now();"
    " setTime(5 + 4.5 * k); place(); return performance.now() - began; })"
)


def open_row(machine: Machine, rounds: int) -> Row:
    """From a click on the file to a page that is ready."""
    with _browser(machine) as (browser, page):
        spent = []
        for _ in range(rounds):
            browser.open("about:blank", wait=False)
            began = time.perf_counter_ns()
            browser.open(page)
            spent.append(time.perf_counter_ns() - began)
    return _row("view", "flexhex view, ten minutes at 4 kHz: open", spent, OPEN)


def scrub_row(machine: Machine, rounds: int) -> Row:
    """Plots and bodies of another instant."""
    with _browser(machine) as (browser, page):
        browser.open(page)
        spent = [1e6 * took for took in browser.run(DRAWN)]
    return _row("scrub", "the same: plots and bodies of one instant", spent, SCRUB)


def _row(key: str, what: str, spent: Sequence[float], required: float) -> Row:
    timing = Timing(key, float(np.median(spent)), float(np.min(spent)))
    return Row(key, what, [timing], 1e9 * required)


@contextmanager
def _browser(machine: Machine) -> Iterator[tuple[Browser, Path]]:
    """A browser and the page; RunError without Chromium."""
    if not any(map(shutil.which, NAMES)):
        raise RunError("the view is measured in Chromium, which is not on the PATH")
    built = run_of(seconds=SECONDS)
    built["feedback.e"][:] += 1e-6 * np.random.default_rng(0).normal(size=built["feedback.e"].shape)
    with tempfile.TemporaryDirectory() as folder:
        runs = named_runs([Path(folder) / "run.h5"], [built])
        data = page_data(runs, machine, (0.0, SECONDS))
        page = write_view(Path(folder) / "view.html", "ten minutes", data)
        browser = Browser(Path(folder) / "profile")
        try:
            yield browser, page
        finally:
            browser.close()


ROWS: dict[str, Callable[[Machine, int], Row]] = {"view": open_row, "scrub": scrub_row}
