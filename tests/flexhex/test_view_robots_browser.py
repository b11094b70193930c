"""Pages of other machines in Chromium: bodies, colours, numbers of joints, runs one at a time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.prepare import Options
from flexhex.view.data import page_data
from flexhex.view.measured import measured_runs
from flexhex.view.page import write_view
from tests.diagnosis.robots.simulated import FILE
from tests.flexhex.browser import Browser
from tests.flexhex.robot_logs import AXIS, FIVE_BAR, arm_log, write
from tests.flexhex.test_view_browser import WINDOWS

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")


def written(folder: Path, logs: list[Path], base: str) -> Path:
    runs, shape, said = measured_runs(logs, None, Options(base))
    data = page_data(runs, shape, (0.0, float("inf")))
    return write_view(folder / "view.html", "logs", {**data, "said": said})


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("logs")
    return [arm_log(folder / f"a{k}.csv", k, 4.0 + k) for k in (1, 2, 3)]


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory, logs: list[Path]) -> Path:
    """One log of the arm."""
    return written(tmp_path_factory.mktemp("arm"), logs[:1], str(FILE))


@pytest.fixture
def shown(browser: Browser, arm: Path) -> Iterator[Browser]:
    """The arm at 1440 px; whatever a test does, the console stays empty."""
    browser.open(arm)
    yield browser
    assert browser.said == []


@pytest.mark.parametrize(("width", "height", "dark"), WINDOWS)
def test_arm_is_drawn_and_moves(
    browser: Browser, arm: Path, width: int, height: int, dark: bool
) -> None:
    browser.open(arm, width, height, dark)
    box = browser.run(
        "(() => { const b = byId('machine').getBoundingClientRect();"
        " return [b.left, b.top, b.right, b.bottom].map(Math.round); })()"
    )
    pictures = []
    for t in (1.0, 3.0):
        browser.run(f"setTime({t})")
        pictures.append(browser.pixels()[box[1] : min(box[3], height), box[0] : box[2]])
    background = np.median(pictures[0].reshape(-1, 3), axis=0)
    assert (background.mean() < 80) == dark
    # an arm is thinner than a hexapod: 3 % of the stage
    assert (np.abs(pictures[0] - background).max(axis=2) > 40).mean() > 0.03
    assert (np.abs(pictures[0] - pictures[1]).max(axis=2) > 40).mean() > 0.005
    assert browser.run("document.documentElement.scrollWidth") <= width
    assert browser.said == []


def test_joint_with_friction_is_the_one_that_is_red(shown: Browser) -> None:
    """Its residual, of its largest torque, is the largest; its signals are those shown first."""
    shown.run("setTime(2)")
    shown.drawn()
    assert shown.run("state.colour") == "residual"
    reds = shown.run("real.hubs.map(hub => hub.color.r - hub.color.b)")
    assert max(range(6), key=reds.__getitem__) == 2
    every = "(_, k) => { setTime(0.5 + 0.1 * k); return shares(DATA.runs[0]); }"
    most = np.max(shown.run(f"Array.from({{length: 40}}, {every})"), axis=0)
    assert most[2] > 0.9
    assert np.delete(most, 2).max() < 0.3, "noise is no colour"
    assert shown.run("[...plots.joints]") == [2]
    assert "of its largest torque" in shown.run("byId('legend').textContent")
    values = shown.run("[...document.querySelectorAll('.values b')].map(b => b.textContent)")
    assert [text.split(":")[0] for text in values] == ["3", "3 model", "3", "3"]
    shown.run("setColour('torque')")
    assert shown.run("byId('legend').textContent").endswith("0100 %")


def test_joints_are_coloured_from_the_first_residual_on(shown: Browser) -> None:
    """Before it there is none; 0.04 s were 19.9999... frames, and its colour that of none."""
    assert max(shown.run("(setTime(DATA.settled), shares(DATA.runs[0]))")) > 0.5


def test_numbers_stand_at_their_joints(shown: Browser) -> None:
    """Within the stage, none over another, the chosen one in its colour."""
    shown.run("stage.look('top'); setTime(2)")
    shown.drawn()
    places = np.array(
        shown.run(
            "[...byId('numbers').children].map(n => { const b = n.getBoundingClientRect();"
            " return [b.left, b.top]; })"
        )
    )
    assert len(places) == 6
    assert np.ptp(places, axis=0).max() > 100
    apart = np.abs(places[:, None] - places).max(axis=2)[~np.eye(6, dtype=bool)]
    assert apart.min() >= 14
    chosen = "[...byId('numbers').children].map(n => n.className)"
    assert shown.run(chosen) == ["", "", "chosen", "", "", ""]
    shown.run("document.querySelectorAll('#joints button')[4].click()")
    shown.drawn()
    assert shown.run(chosen)[4] == "chosen"


def test_on_paper_plots_are_whole_and_nothing_stands_beside_its_place(shown: Browser) -> None:
    style = "(sign, name) => getComputedStyle(document.querySelector(sign))[name]"
    assert shown.run(f"({style})('#numbers', 'display')") != "none"
    shown.call("Emulation.setEmulatedMedia", media="print")
    assert shown.run(f"({style})('#numbers', 'display')") == "none"
    assert shown.run(f"({style})('.chart button', 'display')") == "none"
    assert shown.run(f"({style})('.chart', 'breakInside')") == "avoid"
    shown.call("Emulation.setEmulatedMedia", media="")


def test_mouse_over_a_plot_moves_the_arm(shown: Browser) -> None:
    left, right, y = shown.run(
        "(() => { const b = document.querySelectorAll('.u-over')[1].getBoundingClientRect();"
        " return [b.left, b.right, (b.top + b.bottom) / 2]; })()"
    )
    before = shown.run("JSON.stringify(real.bodies[5].position)")
    shown.mouse("mouseMoved", (left + right) / 2, y)
    assert shown.run("JSON.stringify(real.bodies[5].position)") != before


def test_more_than_two_runs_are_chosen_one_at_a_time(
    browser: Browser, tmp_path: Path, logs: list[Path]
) -> None:
    browser.open(written(tmp_path, logs, str(FILE)))
    assert browser.run("[...byId('run').options].map(o => o.textContent)") == ["a1", "a2", "a3"]
    assert browser.run("plots.charts[0].lines.length") == 2, "torque and model of one run"
    colours = browser.run("plots.charts[0].lines.map(line => line.colour)")
    assert len(set(colours)) == 2, "a dash over a line of its colour is not seen"
    pose, ends = "JSON.stringify(real.bodies[5].position)", []
    seen = set()
    for k in range(3):
        browser.run(f"byId('run').value = {k}; byId('run').dispatchEvent(new Event('change'))")
        browser.drawn()
        ends.append(browser.run("state.range[1]"))
        seen.add(browser.run(pose))
        assert browser.run("plots.charts[0].lines.length") == 2
    assert ends == pytest.approx([4.998, 5.998, 6.998])
    assert len(seen) == 3
    assert browser.said == []


def test_page_without_bodies_has_wide_plots_on_one_cursor(browser: Browser, tmp_path: Path) -> None:
    browser.open(written(tmp_path, [AXIS / "a1.csv", AXIS / "a2.csv"], "axis"))
    assert "no picture" in browser.run("byId('note').textContent")
    assert browser.run("byId('stage').offsetWidth") == 0
    assert browser.run("byId('charts').offsetWidth") > 1400
    browser.run("setTime(3)")
    lefts = browser.run(
        "[...document.querySelectorAll('.u-cursor-x')].map(c => c.getBoundingClientRect().left)"
    )
    assert len(lefts) == 3
    assert np.ptp(lefts) < 1
    before = browser.run("state.t")
    browser.press("ArrowRight", 39)
    assert browser.run("state.t") > before
    assert browser.said == []


def test_bars_of_an_own_model_move(browser: Browser, tmp_path: Path) -> None:
    t = np.arange(2000) * 2e-3
    theta = np.array([2.2, 0.9]) + 0.3 * np.sin(np.outer(t, [2.0, 3.0]))
    tau = np.cos(theta) + 0.01 * np.random.default_rng(1).standard_normal(theta.shape)
    log = write(tmp_path / "a.csv", t, theta, tau)
    browser.open(written(tmp_path, [log], f"{FIVE_BAR}:FiveBar"))
    tips = []
    for at in (1.0, 2.0):
        browser.run(f"setTime({at})")
        browser.drawn()
        tips.append(browser.run("real.bars.slice(2).map(b => b.knob.position.toArray())"))
    assert np.allclose(tips[0][0], tips[0][1], atol=1e-6), "both rods end in one point"
    assert np.abs(np.subtract(tips[0], tips[1])).max() > 0.02
    assert browser.said == []
