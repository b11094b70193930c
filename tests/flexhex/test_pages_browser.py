"""The frame of all pages in Chromium: scheme, width, hover, joints, linked axes, data, print."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.output.page import PageSection, write_page
from flexhex.output.plots import Figure, figure, of_joint, per_joint, trace
from tests.flexhex.browser import Browser

T = np.linspace(0.0, 4.0, 401)
WIDE, NARROW = 1440, 390
CSV = """(async () => {
  let blob = null;
  const made = URL.createObjectURL;
  URL.createObjectURL = one => { blob = one; return made.call(URL, one); };
  document.querySelector(`[aria-label="download the data of %s"]`).click();
  URL.createObjectURL = made;
  return blob.text();
})()"""


def joints() -> Figure:
    """A wave and its double for each of three joints."""
    lines = [
        of_joint(j, trace(T, size * j * np.sin(T), name))
        for j in (1, 2, 3)
        for name, size in (("one", 1.0), ("two", 2.0))
    ]
    return per_joint(figure("Angle of joint {joint}", "time [s]", "θ [rad]", lines), first=2)


def force() -> Figure:
    """Of a joint that slides: in another unit, so a figure of its own."""
    line = of_joint(4, trace(T, np.cos(T), "one"))
    return per_joint(figure("Force of joint {joint}", "time [s]", "F [N]", [line]), first=2)


def error() -> Figure:
    """One line with a comma in its name; its x has other samples."""
    return figure("Error", "time [s]", "e [µrad]", [trace(T[::2], T[::2] ** 2, "a, b")])


def bars() -> Figure:
    """No line at all."""
    bar = {"type": "bar", "x": ["a", "b"], "y": [1.0, None], "name": "size"}
    return figure("Bars", "", "size [m]", [bar])


def dots() -> Figure:
    """Two dots in each of two rows, joined by a line."""
    rows = ["alone<br>fixed", "adaptive"]
    line = {"x": [1.0, 2.0], "y": rows[:1] * 2, "mode": "lines", "meta": {"joins": True}}
    marks = [
        {"x": x, "y": rows, "mode": "markers", "name": name}
        for name, x in (("theirs", [1.0, 3.0]), ("ours", [2.0, 4.0]))
    ]
    return figure("Dots", "e [µrad]", "", [line, *marks])


TIMED = {"angle": joints(), "force": force(), "error": error()}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two linked plots, bars, a wide table, four sections."""
    parts = [
        PageSection("First", figures=TIMED, timed=True),
        PageSection("Second", "a sentence", figures={"bars": bars(), "dots": dots()}, small=True),
        PageSection("Third", headings=("name", *"abcdefgh"), rows=[("row", *["1.234567"] * 8)] * 3),
        PageSection("Fourth", "the answer", answer=True),
    ]
    return write_page(tmp_path_factory.mktemp("page") / "p.html", "A page", "of a test", parts)


@pytest.fixture
def shown(browser: Browser, page: Path) -> Iterator[Browser]:
    """The page at 1440 px; it asks for nothing but itself, and the console stays empty."""
    browser.requests.clear()
    browser.open(page)
    yield browser
    # pictures that the test itself unpacks are data
    strangers = {url for url in browser.requests if not url.startswith(("blob:", "data:"))}
    assert strangers == {page.as_uri()}
    assert browser.said == []


def visible(browser: Browser, plot: str) -> list[Any]:
    """Names and joints of the lines that a plot shows."""
    lines = browser.run(
        f"document.getElementById('{plot}').data.filter(t => t.visible !== false)"
        ".map(t => [t.name, t.meta?.joint])"
    )
    return list(lines)


@pytest.mark.parametrize("width", [WIDE, NARROW])
@pytest.mark.parametrize("dark", [False, True])
def test_page_has_the_scheme_and_the_width_of_its_reader(
    browser: Browser, page: Path, width: int, dark: bool
) -> None:
    browser.open(page, width, 900, dark)
    image = browser.pixels()
    ground = np.median(image.reshape(-1, 3), axis=0).mean()
    assert (ground < 60) == dark
    ink = browser.run(
        "getComputedStyle(document.querySelector('#error .xtick text')).fill.match(/\\d+/g)"
    )
    assert (int(ink[0]) > 150) == dark, "plots follow the scheme"
    assert browser.run("document.documentElement.scrollWidth") <= width
    assert browser.said == []


def test_long_title_is_whole_on_a_narrow_screen(browser: Browser, page: Path) -> None:
    """It goes on in further lines, between the top of the plot and its axes."""
    browser.open(page, NARROW, 900)
    browser.run(
        "figures.error.layout.title.text = 'one word and more '.repeat(6); redraw().then(() => 0)"
    )
    browser.drawn()
    top, begin, end, axes = browser.run(
        "['#error', '#error .gtitle', '#error .gtitle', '#error .nsewdrag'].map((name, k) => {"
        " const box = document.querySelector(name).getBoundingClientRect();"
        " return k === 2 ? box.bottom : box.top; })"
    )
    assert browser.run("document.querySelectorAll('#error .gtitle tspan').length") >= 3
    assert top <= begin < end <= axes


def test_button_changes_the_scheme_and_the_plots(shown: Browser) -> None:
    before = shown.run("document.querySelector('#error .scatterlayer path').style.stroke")
    shown.run("document.getElementById('scheme').click()")
    shown.drawn()
    assert shown.pixels().mean() < 60
    after = shown.run("document.querySelector('#error .scatterlayer path').style.stroke")
    assert after != before
    shown.run("document.getElementById('scheme').click()")
    shown.drawn()
    assert shown.pixels().mean() > 200
    shown.run("localStorage.clear()")


def test_selector_chooses_the_joint_of_all_plots(shown: Browser) -> None:
    assert visible(shown, "angle") == [["one", 2], ["two", 2]]
    assert shown.run("document.querySelector('#angle .gtitle').textContent") == "Angle of joint 2"
    shown.run("document.querySelector('[data-joint=\"3\"]').click()")
    shown.drawn()
    assert visible(shown, "angle") == [["one", 3], ["two", 3]]
    assert visible(shown, "error") == [["a, b", None]]
    assert shown.run("document.querySelector('#angle .gtitle').textContent") == "Angle of joint 3"


def test_joint_whose_figure_is_another_can_be_left_again(shown: Browser) -> None:
    shown.run("document.querySelector('[data-joint=\"4\"]').click()")
    shown.drawn()
    hidden = "['angle', 'force'].map(id => document.getElementById(id).closest('figure').hidden)"
    assert shown.run(hidden) == [True, False]
    beside = "document.getElementById('force').closest('figure').querySelector"
    shown.run(f"{beside}('[data-joint=\"2\"]').click()")
    shown.drawn()
    assert shown.run(hidden) == [False, True]


def test_hover_names_all_lines_with_unit(shown: Browser) -> None:
    x, y = shown.run(
        "(() => { const b = document.querySelector('#angle .nsewdrag').getBoundingClientRect();"
        " return [b.left + b.width / 2, b.top + b.height / 2]; })()"
    )
    shown.mouse("mouseMoved", x - 2, y)
    shown.mouse("mouseMoved", x, y)
    shown.run("new Promise(done => setTimeout(done, 200))")
    text = shown.run("document.querySelector('#angle .hoverlayer').textContent")
    assert "time 2 s" in text
    assert "one : 1.819 rad" in text
    assert "two : 3.637 rad" in text
    lines = shown.run(
        "[...document.querySelectorAll('#angle .spikeline')].map(line =>"
        " [getComputedStyle(line).stroke, getComputedStyle(line).strokeWidth])"
    )
    assert lines, "a line at the time that is read"
    assert {tuple(line) for line in lines} == {("rgb(136, 136, 136)", "1px")}


def test_unit_of_an_element_is_not_its_number(shown: Browser) -> None:
    titles = {"plant.theta[2] [mrad]": "mrad", "plant.kind[2]": "", "[N m]": "N m", "θ [°]": "°"}
    assert {title: shown.run(f"unitOf({json.dumps(title)})") for title in titles} == titles


def test_zoom_of_one_time_axis_zooms_those_linked(shown: Browser) -> None:
    shown.run("Plotly.relayout('angle', {'xaxis.range[0]': 1, 'xaxis.range[1]': 2}).then(() => 0)")
    shown.drawn()
    assert shown.run("document.getElementById('error').layout.xaxis.range") == [1, 2]
    assert shown.run("document.getElementById('bars').layout.xaxis.range") != [1, 2]


def test_download_gives_the_plotted_numbers(shown: Browser) -> None:
    rows = [line.split(",") for line in shown.run(CSV % "Angle of joint 1 to 3").splitlines()]
    assert rows[0][:3] == ["time [s]", "one joint 1: θ [rad]", "two joint 1: θ [rad]"]
    assert len(rows[0]) == 7, "lines that share their samples share a column"
    numbers = np.array([[float(v) for v in row] for row in rows[1:]])
    drawn = joints()["data"]
    assert np.array_equal(numbers[:, 0], drawn[0]["x"])
    for k, line in enumerate(drawn):
        assert np.array_equal(numbers[:, k + 1], line["y"])
    text = shown.run(CSV % "Error")
    assert text.splitlines()[0] == 'time [s],"a, b: e [µrad]"'
    assert shown.run(CSV % "Bars") == "x,size: size [m]\na,1\nb,\n"
    # rows by name, without the lines that join the dots
    table = "name,theirs: e [µrad],ours: e [µrad]\nalone fixed,1,2\nadaptive,3,4\n"
    assert shown.run(CSV % "Dots") == table


def test_axis_has_a_square_as_a_person_writes_it() -> None:
    axis = figure("a", "acceleration [rad/s2]", "", [])["layout"]["xaxis"]
    assert axis["title"]["text"] == "acceleration [rad/s²]"


def test_contents_list_the_sections(shown: Browser) -> None:
    listed = shown.run("[...document.querySelectorAll('.contents a')].map(a => a.textContent)")
    assert listed == ["First", "Second", "Third", "Fourth"]
    hrefs = shown.run("[...document.querySelectorAll('.contents a')].map(a => a.hash)")
    assert all(shown.run(f"document.querySelector({json.dumps(h)}) !== null") for h in hrefs)


def test_print_is_light_and_cuts_nothing(browser: Browser, page: Path) -> None:
    """On paper all plots are as wide as the paper, also from a dark screen; afterwards dark."""
    browser.open(page)
    browser.run("document.getElementById('scheme').click()")
    printed = browser.call("Page.printToPDF", printBackground=False)["data"]
    assert base64.b64decode(printed)[:4] == b"%PDF"
    browser.run("paper(true).then(() => 0)")
    widths = browser.run("[...document.querySelectorAll('.main-svg')].map(s => s.clientWidth)")
    assert max(widths) <= 700
    assert browser.run("document.documentElement.dataset.scheme") == "light"
    browser.run("paper(false).then(() => 0)")
    browser.drawn()
    assert browser.run("document.documentElement.dataset.scheme") == "dark"
    assert browser.run("document.getElementById('error').clientWidth") > 700
    browser.run("localStorage.clear()")
    assert browser.said == []
