"""The page of `flexhex view` in Chromium: it draws, moves, obeys keys and mouse, loads nothing."""

from __future__ import annotations

from collections.abc import Iterator
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

WINDOWS = [(1440, 900, False), (1440, 900, True), (390, 844, False), (390, 844, True)]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of 4 s."""
    folder = tmp_path_factory.mktemp("view")
    results = [run_of(), run_of(size=0.12)]
    runs = named_runs([folder / "first.h5", folder / "second.h5"], results)
    data = page_data(runs, load_machine(MACHINE_FILE), (0.0, 4.0))
    return write_view(folder / "view.html", "two runs", data)


@pytest.fixture
def shown(browser: Browser, page: Path) -> Iterator[Browser]:
    """The page at 1440 px; whatever a test does, the console stays empty."""
    browser.requests.clear()
    browser.open(page)
    yield browser
    assert browser.said == []


@pytest.mark.parametrize(("width", "height", "dark"), WINDOWS)
def test_page_draws_and_moves(
    browser: Browser, page: Path, width: int, height: int, dark: bool
) -> None:
    browser.open(page, width, height, dark)
    box = browser.run(
        "(() => { const b = byId('machine').getBoundingClientRect();"
        " return [b.left, b.top, b.right, b.bottom].map(Math.round); })()"
    )
    pictures = []
    for t in (2.2, 3.0):
        browser.run(f"setTime({t})")
        image = browser.pixels()
        assert image.shape[:2] == (height, width)
        pictures.append(image[box[1] : min(box[3], height), box[0] : box[2], :3])
    # the machine covers a tenth of the stage, and a good part of it is elsewhere a moment later
    background = np.median(pictures[0].reshape(-1, 3), axis=0)
    assert (background.mean() < 80) == dark
    drawn = np.abs(pictures[0] - background).max(axis=2) > 40
    assert drawn.mean() > 0.1
    moved = np.abs(pictures[0] - pictures[1]).max(axis=2) > 40
    assert moved.mean() > 0.02
    browser.run("document.querySelectorAll('#joints [aria-pressed=false]').forEach(b => b.click())")
    browser.drawn()
    wide = browser.run("document.documentElement.scrollWidth")
    assert wide <= width, "nothing sticks out to the side"
    assert browser.said == []


def test_page_asks_for_nothing_but_itself(shown: Browser, page: Path) -> None:
    """Its own parts as blobs, no file, no address; and what a script asks for is refused."""
    assert shown.requests, "what is asked for is seen"
    strangers = {url for url in shown.requests if not url.startswith("blob:null/")}
    assert strangers == {page.as_uri()}
    refused = shown.run("fetch('data:text/plain,x').then(() => 'sent', () => 'refused')")
    assert refused == "refused"
    shown.said.clear()


def test_lines_of_the_plots_are_drawn(shown: Browser) -> None:
    """Pixels in the colours of the runs in each plot, and other ones once joint 2 is chosen too."""
    count = (
        "[...document.querySelectorAll('.plot canvas')].map(c => { const d = c.getContext('2d')"
        ".getImageData(0, 0, c.width, c.height).data; let n = 0; for (let k = 0; k < d.length;"
        " k += 4) { if (Math.max(d[k], d[k+1], d[k+2]) - Math.min(d[k], d[k+1], d[k+2]) > 60"
        " && d[k+3] > 100) { n++; } } return n; })"
    )
    shown.drawn()
    before = shown.run(count)
    assert len(before) == 3
    assert min(before) > 300
    shown.run("document.querySelectorAll('#joints button')[1].click()")
    shown.drawn()
    after = shown.run(count)
    assert all(b > a for a, b in zip(before, after, strict=True))


def test_line_of_a_constant_signal_is_drawn(shown: Browser) -> None:
    """It is sent as two points, which span the whole plot."""
    shown.run("plots.add('plant.fault')")
    shown.drawn()
    counted = shown.run(
        "(() => { const c = [...document.querySelectorAll('.plot canvas')].at(-1);"
        " const row = c.getContext('2d').getImageData(0, c.height / 2 - 30, c.width, 60).data;"
        " const columns = new Set(); for (let k = 0; k < row.length; k += 4) {"
        " if (Math.max(row[k], row[k+1], row[k+2]) - Math.min(row[k], row[k+1], row[k+2]) > 60)"
        " { columns.add(k / 4 % c.width); } } return columns.size / c.width; })()"
    )
    assert counted > 0.5


def test_payload_stands_on_the_platform_while_it_is_carried(
    browser: Browser, tmp_path: Path
) -> None:
    built = run_of()
    group = built.group("plant.theta")
    group.signals["reference.payload"] = np.where(group.time < 3.0, 0.0, 0.5)  # type: ignore[index]
    runs = named_runs([tmp_path / "run.h5"], [built])
    data = page_data(runs, load_machine(MACHINE_FILE), (0.0, 4.0))
    browser.open(write_view(tmp_path / "view.html", "payload", data))
    seen = []
    for t in (2.9, 3.1):
        browser.run(f"setTime({t})")
        browser.drawn()
        seen.append(browser.run("[real.load.visible, real.load.body.scale.x]"))
    assert [visible for visible, _ in seen] == [False, True]
    # aluminium: as high as its radius
    assert 2700 * np.pi * seen[1][1] ** 3 == pytest.approx(0.5)
    assert browser.said == []


def test_keys_move_time_magnify_and_choose(shown: Browser) -> None:
    assert shown.run("state.t") == 2.0
    shown.press("ArrowRight", 39)
    step = shown.run("DATA.runs[0].frames.step")
    assert shown.run("state.t") == pytest.approx(2.0 + step)
    shown.press("End", 35)
    assert shown.run("state.t") == pytest.approx(4.0)
    shown.press("Home", 36)
    assert shown.run("state.t") == 2.0
    for _ in range(4):
        shown.press("+", 187, "+")
    assert shown.run("state.factor") == pytest.approx(10.0)
    assert shown.run("byId('factor').textContent") == "10"
    assert shown.run("state.ghost") == "second"
    for ghost in ("beside", "wanted"):
        shown.press("g", 71, "g")
        assert shown.run("state.ghost") == ghost
    shown.press("c", 67, "c")
    assert shown.run("state.colour") == "error"
    # so slow that a busy computer does not reach the end, where it stops by itself
    shown.run("void (state.speed = 0.01)")
    shown.press(" ", 32, " ")
    assert shown.run("state.playing") is True
    shown.run("new Promise(done => setTimeout(done, 300))")
    assert shown.run("state.t") > 2.0
    shown.press(" ", 32, " ")
    assert shown.run("state.playing") is False


def test_mouse_over_a_plot_moves_the_machine(shown: Browser) -> None:
    """The middle of the time axis is the middle of the range; the other plots' cursors follow."""
    left, right, y = shown.run(
        "(() => { const b = document.querySelectorAll('.u-over')[1].getBoundingClientRect();"
        " return [b.left, b.right, (b.top + b.bottom) / 2]; })()"
    )
    before = shown.run("JSON.stringify(real.platform.position)")
    shown.mouse("mouseMoved", (left + right) / 2, y)
    assert shown.run("state.t") == pytest.approx(3.0, abs=0.01)
    assert shown.run("JSON.stringify(real.platform.position)") != before
    cursors = shown.run(
        "[...document.querySelectorAll('.u-cursor-x')].map(c => c.getBoundingClientRect().left)"
    )
    assert np.allclose(cursors, (left + right) / 2, atol=2)
    assert float(shown.run("byId('time').value")) == pytest.approx(3.0, abs=0.01)


def test_dragging_in_a_plot_zooms_all(shown: Browser) -> None:
    left, right, y = shown.run(
        "(() => { const b = document.querySelector('.u-over').getBoundingClientRect();"
        " return [b.left, b.right, (b.top + b.bottom) / 2]; })()"
    )
    width = right - left
    shown.mouse("mouseMoved", left + 0.25 * width, y)
    shown.mouse("mousePressed", left + 0.25 * width, y, "left")
    shown.mouse("mouseMoved", left + 0.75 * width, y, "left")
    shown.mouse("mouseReleased", left + 0.75 * width, y, "left")
    assert shown.run("state.range") == pytest.approx([2.5, 3.5], abs=0.02)
    scales = shown.run("plots.charts.map(c => [c.plot.scales.x.min, c.plot.scales.x.max]).flat()")
    assert scales == pytest.approx([2.5, 3.5] * 3, abs=0.02)


def test_magnified_error_is_that_many_times_the_error(shown: Browser) -> None:
    """Angles r - factor e, with e what the run holds at that time."""
    e, theta, magnified, wanted = shown.run(
        "[at(DATA.runs[0].frames, 'e', 3),"
        " ...[1, 100, 0].map(f => angles(DATA.runs[0].frames, 3, f))]"
    )
    built = run_of()
    place = round(3 / built.group("feedback.e").Ts)
    assert np.allclose(e, built["feedback.e"][place], atol=1e-11)
    r = built["reference.r"][place]
    # angles are sent as float32: 6e-8 of 0.1 rad
    assert np.allclose(theta, built["plant.theta"][place], atol=1e-8)
    assert np.allclose(wanted, r, atol=1e-8)
    assert np.allclose(magnified, r - 100 * built["feedback.e"][place], atol=1e-8)


def test_error_is_drawn_no_larger_than_the_machine_can_show(shown: Browser) -> None:
    """10 mrad 10000 times would be 100 rad; what is drawn instead is said, the same as for 25."""
    shown.run("DATA.runs[0].frames.e.fill(0.01); setFactor(4)")
    shown.drawn()
    assert "error\u00a0×\u00a025 here" in shown.run("byId('said').textContent")
    turned = shown.run(
        "[25, 1e4].map(f => angles(DATA.runs[0].frames, state.t,"
        " magnified(DATA.runs[0].frames, state.t, f)))"
    )
    assert turned[1] == pytest.approx(turned[0])
    shown.run("setFactor(0)")
    shown.drawn()
    assert shown.run("byId('said').textContent") == ""


def test_runs_beside_each_other_say_how_large_their_error_is(shown: Browser) -> None:
    """Each has a ghost where it should be, and its name says the magnification that it takes."""
    shown.run("DATA.runs[0].frames.e.fill(0.001); setGhost('beside'); setFactor(3)")
    shown.drawn()
    names = shown.run("[...byId('names').children].map(name => name.textContent)")
    assert names == ["first, error\u00a0×\u00a0250", "second, error\u00a0×\u00a01000"]
    assert shown.run("byId('said').textContent") == ""
    ghosts = shown.run(
        "[ghost, twin].map(one => [one.root.visible, Math.sign(one.root.position.x)])"
    )
    assert ghosts == [[True, -1], [True, 1]]
    assert shown.run("real.root.position.x === ghost.root.position.x")


def test_angles_that_the_mechanism_cannot_take_are_said(shown: Browser) -> None:
    shown.run("DATA.runs[0].frames.theta.fill(2); place()")
    assert "cannot take these angles" in shown.run("byId('said').textContent")
