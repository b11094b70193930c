"""Small multiples in Chromium: a panel for each joint, one selector, linked times, data, print."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from flexhex.ssp.results import save
from flexhex.view.sources import load_source
from tests.flexhex.browser import Browser
from tests.flexhex.test_pages_browser import CSV, NARROW, WIDE
from tests.flexhex.test_view import run_of

JOINTS = 6


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Errors and angles of six joints, and the angle of one."""
    from flexhex.plot.draw import chosen, write_plots

    folder = tmp_path_factory.mktemp("plot")
    result = load_source(save(run_of(), folder / "run.h5"))
    picked = chosen(result, ["feedback.e", "plant.theta", "plant.theta[2]"], (0.0, 4.0))
    return write_plots(picked, "a run", folder / "plot.html")


@pytest.fixture
def shown(browser: Browser, page: Path) -> Iterator[Browser]:
    """The page at 1440 px; the console stays empty."""
    browser.open(page, WIDE, 1600)
    yield browser
    assert browser.said == []


def panels(browser: Browser, plot: str = "signal0") -> np.ndarray:
    """Left, top, right, bottom of the panels that a plot shows (n, 4) [px]."""
    result = browser.run(
        f"[...document.querySelectorAll('#{plot} .nsewdrag')].map(p => {{ const b ="
        " p.getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]; })"
    )
    return np.array(result)


@pytest.mark.parametrize(("width", "columns"), [(WIDE, 3), (800, 2), (NARROW, 1)])
@pytest.mark.parametrize("dark", [False, True])
def test_each_joint_has_a_panel_that_lies_on_no_other(
    browser: Browser, page: Path, width: int, columns: int, dark: bool
) -> None:
    browser.open(page, width, 900, dark)
    boxes = panels(browser)
    assert len(boxes) == JOINTS
    assert len({round(left) for left in boxes[:, 0]}) == columns
    assert browser.run("document.documentElement.scrollWidth") <= width
    for k, (left, top, right, bottom) in enumerate(boxes):
        assert right - left > 200
        assert bottom - top > 100
        for other in boxes[:k]:
            assert right <= other[0] or other[2] <= left or bottom <= other[1] or other[3] <= top
    names = browser.run(
        "[...document.querySelectorAll('#signal0 .annotation')].map(a => a.textContent)"
    )
    assert names == [f"joint {k} [µrad]" for k in range(1, JOINTS + 1)]
    assert browser.said == []


def test_window_that_gets_narrow_has_fewer_columns(shown: Browser) -> None:
    shown.call(
        "Emulation.setDeviceMetricsOverride",
        width=NARROW, height=900, deviceScaleFactor=1, mobile=False,
    )  # fmt: skip
    for _ in range(50):
        if len({round(left) for left in panels(shown)[:, 0]}) == 1:
            return
        shown.run("new Promise(done => setTimeout(done, 100))")
    raise AssertionError("still several columns")


def test_selector_shows_one_joint_of_all_signals(shown: Browser) -> None:
    before = panels(shown)
    shown.run("document.querySelector('[data-joint=\"4\"]').click()")
    shown.run("new Promise(done => setTimeout(done, 300))")
    for plot in ("signal0", "signal1"):
        (box,) = panels(shown, plot)
        assert box[2] - box[0] > 2 * (before[0, 2] - before[0, 0])
        lines = shown.run(
            f"document.getElementById('{plot}').data.filter(t => t.visible !== false)"
            ".map(t => t.name)"
        )
        assert [name[-3:] for name in lines] == ["[4]"]
        low, high = shown.run(f"document.getElementById('{plot}')._fullLayout.yaxis.range")
        drawn = shown.run(f"figures['{plot}'].data[3].y")
        assert low < min(drawn) < max(drawn) < high
        assert high - low < 1.5 * np.ptp(drawn)
    shown.run("document.querySelector('[data-joint=\"0\"]').click()")
    shown.run("new Promise(done => setTimeout(done, 300))")
    assert len(panels(shown)) == JOINTS


def test_zoom_in_one_panel_zooms_all_and_stays(shown: Browser) -> None:
    left, top, right, bottom = panels(shown)[2]
    y, places = (top + bottom) / 2, [left + part * (right - left) for part in (0.25, 0.5, 0.75)]
    shown.mouse("mouseMoved", places[0], y)
    shown.mouse("mousePressed", places[0], y, "left")
    shown.mouse("mouseMoved", places[1], y, "left")
    shown.mouse("mouseMoved", places[2], y, "left")
    shown.mouse("mouseReleased", places[2], y, "left")
    shown.run("new Promise(done => setTimeout(done, 600))")
    ranges = (
        "[['signal0', 'xaxis5'], ['signal1', 'xaxis'], ['signal1', 'xaxis6'], ['signal2', 'xaxis']]"
        ".map(([id, axis]) => document.getElementById(id)._fullLayout[axis].range)"
    )
    assert np.allclose(shown.run(ranges), [1.0, 3.0], atol=0.05)
    shown.run("document.querySelector('[data-joint=\"4\"]').click()")
    shown.run("new Promise(done => setTimeout(done, 300))")
    one = shown.run("document.getElementById('signal1')._fullLayout.xaxis.range")
    assert np.allclose(one, [1.0, 3.0], atol=0.05)


def test_time_under_the_pointer_is_shown_in_all_panels(shown: Browser) -> None:
    left, top, right, bottom = panels(shown)[1]
    for k in (2, 0):
        shown.mouse("mouseMoved", (left + right) / 2 - k, (top + bottom) / 2)
        shown.run("new Promise(done => setTimeout(done, 300))")
    labels = shown.run(
        "[...document.querySelectorAll('#signal0 .hovertext')].map(t => t.textContent)"
    )
    time = float(shown.run("document.querySelector('#signal0 .axistext').textContent"))
    assert time == pytest.approx(2.0, abs=0.02)
    built = run_of()
    wanted = built["feedback.e"][round(time / built.group("feedback.e").Ts)] * 1e6
    assert all(text.endswith(" µrad") for text in labels)
    times = [float(text.split()[0].replace("−", "-")) for text in labels]
    # of thinned lines a point is within 2 ms, in which the error moves by up to 1.6 urad
    assert np.allclose(sorted(times), sorted(wanted), atol=1.6)


def test_panels_can_have_scales_of_their_own(shown: Browser) -> None:
    shown.run(
        "figures.signal1.data[1].y = figures.signal1.data[1].y.map(v => 10 * v);"
        " draw('signal1').then(() => 0)"
    )
    heights = (
        "['yaxis', 'yaxis2'].map(a => document.getElementById('signal1')._fullLayout[a].range)"
        ".map(([a, b]) => b - a)"
    )
    assert np.ptp(shown.run(heights)) == pytest.approx(0.0)
    shown.run("document.querySelectorAll('.scale')[1].click()")
    shown.run("new Promise(done => setTimeout(done, 300))")
    first, second = shown.run(heights)
    assert second == pytest.approx(10 * first, rel=0.1)


def test_data_of_a_signal_are_those_of_all_joints(shown: Browser) -> None:
    rows = shown.run(CSV % "feedback.e").splitlines()
    assert rows[0].startswith("time [s],")
    assert sum("feedback.e[" in name for name in rows[0].split(",")) == JOINTS
    assert shown.run(CSV % "plant.theta[2] [mrad]").splitlines()[0].endswith("[mrad]")


def test_print_has_all_panels_on_its_paper(shown: Browser) -> None:
    shown.run("paper(true).then(() => 0)")
    boxes = panels(shown)
    assert len(boxes) == JOINTS
    assert np.ptp(boxes[:, [0, 2]]) <= 700
    shown.run("paper(false).then(() => 0)")
    shown.drawn()
    assert np.ptp(panels(shown)[:, [0, 2]]) > 700
