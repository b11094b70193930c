"""The page of `flexhex view` with a long run, on a computer without a graphics card."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.compare.runs import named_runs
from flexhex.fmus.common.machine_file import load_machine
from flexhex.view.data import page_data
from flexhex.view.page import write_view
from tests.conftest import MACHINE_FILE
from tests.flexhex.browser import Browser
from tests.flexhex.test_view import run_of
from tests.flexhex.test_view_browser import page, shown

__all__ = ["page", "shown"]


def test_bars_of_a_long_run_keep_the_extremes_and_hang_together(shown: Browser) -> None:
    """7001 points in 500 columns: one bar a column, which reaches from the lowest to the highest
    of its points and meets the bar before it."""
    shown.run(
        "window.wave = Float32Array.from({ length: 7001 }, (_, k) => 50 * Math.sin(k / 40)"
        " + Math.sin(k) * (k % 7)); window.drawn = [];"
        " window.found = plots.columns(wave, 0, 7000, k => k / 14 + 0.3); plots.bars(found,"
        " (top, bottom, column) => drawn.push([top, bottom, column]))"
    )
    points = np.array(shown.run("Array.from(wave)"))
    bars = np.array(shown.run("drawn"))
    columns = np.floor(np.arange(7001) / 14 + 0.3).astype(int)
    for column, low, high, early in shown.run("found"):
        own = points[columns == column]
        assert (low, high, early) == (own.min(), own.max(), own.argmin() <= own.argmax())
    assert bars[:, 2].tolist() == list(range(columns[-1] + 1))
    for (top, bottom, column), before in zip(bars, [None, *bars], strict=False):
        own = points[columns == column]
        assert top >= own.max()
        assert bottom <= own.min()
        if before is None:
            assert (top, bottom) == (own.max(), own.min())
        else:
            earlier = points[columns == column - 1]
            assert top == max(own.max(), earlier.min())
            assert bottom == min(own.min(), earlier.max())


def test_gaps_of_a_line_make_no_column(shown: Browser) -> None:
    """Two points a column; one is no number, and both of the third column are none."""
    result = shown.run(
        "plots.columns(Float32Array.of(NaN, 2, 3, 1, NaN, NaN, 5, NaN), 0, 7, k => k / 2)"
    )
    assert result == [[0, 2, 2, True], [1, 1, 3, False], [3, 5, 5, True]]


def test_motion_is_coarse_only_where_pictures_come_late(shown: Browser) -> None:
    shown.run(
        "(async () => { stage.card = true; for (let k = 0; k < 12; k++) { setTime(2 + 0.1 * k);"
        " const end = performance.now() + 90; while (performance.now() < end);"
        " await new Promise(requestAnimationFrame); } })()"
    )
    ratio, moving = shown.run("[stage.rough, stage.renderer.getPixelRatio()]")
    assert moving == ratio
    shown.run("new Promise(done => setTimeout(done, 2000))")
    assert shown.run("stage.renderer.getPixelRatio() === stage.fine")


def test_without_a_graphics_card_motion_is_coarse_from_its_third_picture(shown: Browser) -> None:
    """The browser of the tests has none. At rest all is drawn: more pixels than the screen has, in
    place of smoothed edges, and shadows."""
    card, smoothed = shown.run(
        "[stage.card, stage.renderer.getContext().getContextAttributes().antialias]"
    )
    assert (card, smoothed) == (False, False)
    drawn = "[stage.renderer.getPixelRatio(), stage.sun.castShadow]"
    shown.run("new Promise(done => setTimeout(done, 2000))")
    assert shown.run(drawn) == [1.5, True]
    moving = shown.run(f"[1, 2, 3].map(() => {{ stage.pace(16, true); return {drawn}; }})")
    assert moving == [[1.5, True], [1.5, True], [0.5, False]]
    shown.run("new Promise(done => setTimeout(done, 2000))")
    assert shown.run(drawn) == [1.5, True]


def test_ghost_that_would_not_be_seen_is_not_drawn(shown: Browser) -> None:
    """Below half a milliradian: a tenth of a pixel. It costs as much as the machine itself."""
    shown.run("setGhost('wanted'); DATA.runs[0].frames.e.fill(1e-5); setFactor(1); place()")
    assert shown.run("ghost.root.visible") is False
    shown.run("setFactor(2); place()")
    assert shown.run("ghost.root.visible") is True


@pytest.mark.slow
def test_ten_minutes_at_4_khz_are_shown_without_a_complaint(
    browser: Browser, tmp_path: Path
) -> None:
    """How fast is measured by `python -m benchmarks --only view`."""
    built = run_of(seconds=600.0)
    runs = named_runs([tmp_path / "run.h5"], [built])
    data = page_data(runs, load_machine(MACHINE_FILE), (0.0, 600.0))
    browser.open(write_view(tmp_path / "view.html", "ten minutes", data))
    shown = browser.run("[5, 300, 599].map(t => { setTime(t); place(); return state.t; })")
    assert shown == [5, 300, 599]
    assert browser.said == []
