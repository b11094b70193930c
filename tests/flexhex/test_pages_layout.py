"""What may cover something else in the plots of a page: on a phone, in print of half a page."""

from __future__ import annotations

import json
from pathlib import Path

from flexhex.output.page import PageSection, write_page
from tests.flexhex.browser import Browser
from tests.flexhex.test_pages_browser import NARROW, page

__all__ = ["page"]


def boxes(browser: Browser, *names: str) -> list[list[float]]:
    """Left, top, right, bottom of parts of the page [px]."""
    result = browser.run(
        f"{json.dumps(names)}.map(name => {{ const b ="
        " document.querySelector(name).getBoundingClientRect();"
        " return [b.left, b.top, b.right, b.bottom]; })"
    )
    return list(result)


def test_legend_below_a_narrow_plot_leaves_room_for_the_title_of_its_axis(
    browser: Browser, page: Path
) -> None:
    """Names so long that each entry has a row of its own."""
    browser.open(page, NARROW, 900)
    browser.run(
        "figures.error.data = Array.from({ length: 4 }, (_, k) => ({ ...figures.error.data[0],"
        " name: `backward, measured ${k}` })); redraw().then(() => 0)"
    )
    browser.drawn()
    ticks, title, legend = boxes(browser, "#error .xtick", "#error .xtitle", "#error .legend")
    assert ticks[3] <= title[1] < title[3] <= legend[1]


def test_contents_beside_the_page_stand_off_its_edge(browser: Browser, page: Path) -> None:
    """At the width from which on they stand there."""
    browser.open(page, 1365, 900)
    contents, main = boxes(browser, ".contents", "main")
    assert 10 <= contents[0] < contents[2] <= main[0] + 10


def test_number_behind_a_bar_is_whole_on_a_narrow_screen(browser: Browser, page: Path) -> None:
    browser.open(page, NARROW, 900)
    browser.run(
        "Object.assign(figures.bars.data[0], { orientation: 'h', x: [32.3, 1], y: ['a', 'b'],"
        " text: ['32.3', '1.0'], textposition: 'outside', cliponaxis: false });"
        " figures.bars.layout.margin = { r: 45, l: 20 }; redraw().then(() => 0)"
    )
    browser.drawn()
    text, plot = boxes(browser, "#bars .bartext", "#bars .main-svg")
    assert text[2] <= plot[2]


def test_title_of_half_a_page_stands_above_its_legend_in_print(
    browser: Browser, page: Path
) -> None:
    browser.open(page)
    browser.run(
        "figures.bars.data = ['published figures', 'simulated figures'].map(name =>"
        " ({ ...figures.bars.data[0], name })); Object.assign(figures.bars.layout, { margin:"
        " { l: 20, r: 15, t: 90 }, legend:"
        " { orientation: 'h', x: 0, y: 1.02, yanchor: 'bottom' } });"
        " paper(true).then(() => 0)"
    )
    browser.drawn()
    title, legend = boxes(browser, "#bars .gtitle", "#bars .legend")
    assert title[3] <= legend[1]


def test_plot_without_lines_of_the_chosen_joint_is_hidden(browser: Browser, page: Path) -> None:
    """Plots that no joint has stay."""
    browser.open(page)
    browser.run("figures.angle.data = figures.angle.data.filter(line => line.meta.joint < 3)")
    hidden = "['angle', 'error'].map(id => document.getElementById(id).closest('figure').hidden)"
    seen = [browser.run(f"choose({joint}).then(() => {hidden})") for joint in (2, 3, 1)]
    assert seen == [[False, False], [True, False], [False, False]]


def test_first_column_stays_while_a_wide_table_is_moved(browser: Browser, page: Path) -> None:
    """The page itself is no wider than the screen; nothing of the table stands over its names."""
    browser.open(page, NARROW, 900)
    assert browser.run("document.documentElement.scrollWidth") <= NARROW
    before = boxes(browser, ".wide tr:nth-child(2) td:first-child")[0]
    room = browser.run(
        "(() => { const w = document.querySelector('.wide'); w.scrollLeft = 90;"
        " return [w.scrollLeft, w.scrollWidth > w.clientWidth]; })()"
    )
    assert room == [90, True]
    after = boxes(browser, ".wide tr:nth-child(2) td:first-child")[0]
    assert after == before
    seen = browser.run(
        "(() => { const b = document.querySelector('.wide tr:nth-child(2) td');"
        " b.scrollIntoView({ block: 'center' }); const r = b.getBoundingClientRect();"
        " return document.elementFromPoint(r.right - 4, (r.top + r.bottom) / 2) === b; })()"
    )
    assert seen


def test_table_of_words_stands_row_by_row_on_a_narrow_screen(
    browser: Browser, tmp_path: Path
) -> None:
    rows = [("Log one more run.", "flexhex diagnose " + "a-very-long-name.csv " * 6)] * 2
    part = PageSection("Next", "", ("", "command"), rows, words=True)
    browser.open(write_page(tmp_path / "p.html", "A page", "", [part]), NARROW, 900)
    what, command = boxes(browser, ".words tr:nth-child(2) td", ".words tr:nth-child(2) td + td")
    assert what[3] <= command[1]
    assert command[2] <= NARROW
    assert browser.run("document.documentElement.scrollWidth") <= NARROW


def test_wide_table_is_whole_in_print(browser: Browser, page: Path) -> None:
    browser.open(page, 718, 1000)
    browser.call("Emulation.setEmulatedMedia", media="print")
    browser.run("paper(true).then(() => 0)")
    (table,) = boxes(browser, ".wide table")
    assert table[2] <= 718
    browser.call("Emulation.setEmulatedMedia", media="")


def test_long_title_of_an_axis_is_whole_on_a_narrow_screen(browser: Browser, page: Path) -> None:
    browser.open(page, NARROW, 900)
    browser.run(
        "figures.error.layout.xaxis.title.text = 'gain on left-out trajectories of others [nats]';"
        " redraw().then(() => 0)"
    )
    browser.drawn()
    ticks, title, plot = boxes(browser, "#error .xtick", "#error .xtitle", "#error .main-svg")
    assert plot[0] <= title[0] < title[2] <= plot[2]
    # boxes are rounded to parts of a pixel, each in its own way
    assert ticks[3] <= title[1] < title[3] <= plot[3] + 0.5


def test_plot_of_many_lines_keeps_its_height_on_a_narrow_screen(
    browser: Browser, page: Path
) -> None:
    """Its legend stands below it, and makes it taller."""
    browser.open(page, NARROW, 900)
    shown = "document.querySelector('#error .nsewdrag').getBoundingClientRect().height"
    before = browser.run(shown)
    browser.run(
        "figures.error.data = Array.from({ length: 9 }, (_, k) => ({ ...figures.error.data[0],"
        " name: `end_effector.${k}` })); redraw().then(() => 0)"
    )
    browser.drawn()
    # two rows of its legend, 22 px each, and 10 px for the title are taken off the plot
    assert browser.run(shown) >= before - 54
    title, legend = boxes(browser, "#error .xtitle", "#error .legend")
    assert title[3] <= legend[1]


def test_title_beside_a_narrow_plot_is_clear_of_its_labels(browser: Browser, page: Path) -> None:
    browser.open(page, NARROW, 900)
    browser.run(
        "figures.error.data = [{ ...figures.error.data[0], y: figures.error.data[0].y.map(v =>"
        " -0.008 * v) }]; redraw().then(() => 0)"
    )
    browser.drawn()
    labels = browser.run(
        "Math.min(...[...document.querySelectorAll('#error .ytick')].map(t =>"
        " t.getBoundingClientRect().left))"
    )
    assert boxes(browser, "#error .ytitle")[0][2] <= labels


def test_table_without_headings_has_no_empty_row(browser: Browser, tmp_path: Path) -> None:
    parts = [PageSection("Findings", headings=("",), rows=[("one",), ("two",)], words=True)]
    browser.open(write_page(tmp_path / "p.html", "A page", "", parts))
    assert browser.run("document.querySelectorAll('.words tr').length") == 2


def test_menu_of_a_plot_stands_above_it_on_a_narrow_screen(browser: Browser, page: Path) -> None:
    browser.open(page, NARROW, 900)
    before = boxes(browser, "#error .nsewdrag")[0]
    browser.run(
        "figures.error.layout.updatemenus = [{"
        " buttons: [{ label: 'end-effector', method: 'skip' }], x: 1.02, xanchor: 'left',"
        " y: 1 }]; redraw().then(() => 0)"
    )
    browser.drawn()
    title, menu, plot = boxes(
        browser, "#error .gtitle", "#error .updatemenu-container", "#error .nsewdrag"
    )
    assert title[3] <= menu[1] < menu[3] <= plot[1]
    assert plot[2] - plot[0] == before[2] - before[0]


def test_labels_that_stand_upright_cover_nothing_on_a_narrow_screen(
    browser: Browser, page: Path
) -> None:
    browser.open(page, NARROW, 900)
    browser.run(
        "figures.error.data = ['fit', 'adapted'].map(name => ({ ...figures.error.data[0], name }));"
        " Object.assign(figures.error.layout.xaxis, { tickvals: [0.5, 0.8], tickangle: -30,"
        " ticktext: ['upper arms', 'end-effector'], title: { text: '' } }); redraw().then(() => 0)"
    )
    browser.drawn()
    labels = "[...document.querySelectorAll('#error .xtick')].map(t => t.getBoundingClientRect())"
    first, second = browser.run(f"{labels}.map(b => [b.left, b.right, b.bottom])")
    assert first[1] <= second[0]
    assert max(first[2], second[2]) <= boxes(browser, "#error .legend")[0][1]


def test_heads_of_tables_come_again_on_each_page_of_paper(browser: Browser, page: Path) -> None:
    """And a table that fits on a page stays in one piece."""
    browser.open(page, 718, 1000)
    browser.call("Emulation.setEmulatedMedia", media="print")
    style = "(name, key) => getComputedStyle(document.querySelector(name))[key]"
    assert browser.run(f"({style})('.wide thead', 'display')") == "table-header-group"
    assert browser.run(f"({style})('.wide thead th', 'position')") == "static"
    assert browser.run(f"({style})('.wide table', 'breakInside')") == "avoid"
    browser.call("Emulation.setEmulatedMedia", media="")
