"""`flexhex compare`: names, tracking figures, exit codes, JSON and page."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from flexhex.compare.command import compare_command
from flexhex.compare.results import EQUAL
from flexhex.compare.runs import figures, load_runs
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.output.page import PageSection, write_page
from flexhex.output.plots import COLOURS, figure
from flexhex.ssp.results import Result, save
from tests.flexhex.test_compare import BASE, N, result, wave


def tracked(e: float, tau: float, seconds: float = 3.0, **meta: str) -> Result:
    """Errors of 1 rad until 2 s, then e and -e [rad] by turns in two joints; torque tau [N m]."""
    count = round(seconds / BASE) + 1
    error = np.full((count, 2), e)
    error[::2] *= -1
    settling = np.arange(count) * BASE <= 2.0
    error[settling] = 1.0
    torque = np.where(settling[:, None], 9.0, np.full((count, 2), tau))
    run = result({"feedback.e": error, "feedback.tau_fb": torque}, meta=meta)
    return Result(run.groups, duration=seconds, meta=meta)


@pytest.fixture
def app() -> typer.Typer:
    """The command as `flexhex.cli` registers it."""
    application = typer.Typer()
    application.command("compare")(compare_command)
    application.callback()(lambda: None)
    return application


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    """Two files that differ by 1e-4 in one column of one of two signals."""
    changed = wave()
    changed[100:, 2] += 1e-4
    fault = np.zeros(N)
    a, b = ({"plant.theta": x, "plant.fault": fault} for x in (wave(), changed))
    first, second = tmp_path / "a.h5", tmp_path / "b.h5"
    return save(result(a, meta={"made": "here"}), first), save(
        result(b, meta={"made": "</script>there"}), second
    )


def test_exit_code_tells_equal_from_different(
    app: typer.Typer, runs: tuple[Path, Path], tmp_path: Path
) -> None:
    words = ["compare", *map(str, runs), "--page", str(tmp_path / "page.html")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 1
    assert "plant.theta[3]" in done.stdout
    assert "different: 1 of 2 signals within tolerance" in done.stdout
    for within in (["--atol", "2e-4"], ["--rtol", "2e-6"], ["--tol", "plant.theta=2e-4"]):
        assert CliRunner().invoke(app, [*words, *within]).exit_code == 0
    assert CliRunner().invoke(app, [*words, "--tol", "plant.theta=9e-5"]).exit_code == 1


def test_json_says_all(app: typer.Typer, runs: tuple[Path, Path], tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["compare", *map(str, runs), "--json", "--plots", "0"])
    data = json.loads(done.stdout)
    assert (data["equal"], data["page"]) == (False, None)
    theta, fault = data["signals"]
    assert theta["worst"] == pytest.approx(1e-4)
    assert theta["first"] == pytest.approx(100 * BASE)
    assert (fault["state"], fault["first"]) == (EQUAL, None)
    assert data["provenance"] == {"made": {"first": "here", "second": "</script>there"}}


def test_page_holds_overlay_and_difference_and_needs_no_network(
    app: typer.Typer, runs: tuple[Path, Path], tmp_path: Path
) -> None:
    page = tmp_path / "new" / "page.html"
    CliRunner().invoke(app, ["compare", *map(str, runs), "--page", str(page)])
    text = page.read_text(encoding="utf-8")
    assert re.findall(r'class="plot" id="([\w-]+)"', text) == ["overlay0", "difference0"]
    drawn = json.loads(re.search(r"^const figures = (.*);$", text, re.M)[1])  # type: ignore[index]
    gap = drawn["difference0"]["data"][0]["y"]
    assert gap[0] == 0
    assert gap[-1] == pytest.approx(100.0, rel=1e-3)
    assert drawn["difference0"]["layout"]["yaxis"]["title"]["text"] == "difference [µrad]"
    assert "&lt;/script&gt;there" in text, "what a file says is text, not markup"
    assert not re.search(r"<(script|img|iframe)[^>]*\ssrc=|<link", text)


def test_text_in_a_plot_cannot_end_the_script(tmp_path: Path) -> None:
    drawn = {"place": figure("</script><b>", "t", "y", [])}
    path = write_page(tmp_path / "p.html", "", "", [PageSection("one", figures=drawn)])
    text = path.read_text(encoding="utf-8")
    assert "</script><b>" not in text
    match = re.search(r"^const figures = (.*);$", text, re.M)
    assert match
    assert json.loads(match[1])["place"]["layout"]["title"]["text"] == "</script><b>"


def test_bad_input_has_exit_code_3(app: typer.Typer, runs: tuple[Path, Path]) -> None:
    (runs[1].parent / "broken.h5").write_bytes(runs[0].read_bytes()[:900])
    for name in ("missing.h5", "broken.h5"):
        words = ["compare", str(runs[0]), str(runs[1].parent / name)]
        error = CliRunner().invoke(app, words).exception
        assert isinstance(error, LogError)
        assert error.exit_code == 3
        assert name in str(error)


@pytest.fixture
def cases(tmp_path: Path) -> tuple[Path, Path]:
    """The adaptive case first, as HDF5; then a longer fixed one, as CSV."""
    adaptive = tracked(30e-6, 0.002, case="adaptive", title="adaptive feedforward")
    adaptive["feedback.e"][9000, 1] = -45e-6
    fixed = tracked(40e-6, 0.004, seconds=3.5, case="fixed", title="fixed feedforward")
    fixed["feedback.e"][-1, 0] = 1.0  # after the end of the other
    return save(adaptive, tmp_path / "a.h5"), save(fixed, tmp_path / "b.csv")


def test_tracking_figures_come_first_with_their_ratio(
    app: typer.Typer, cases: tuple[Path, Path]
) -> None:
    """After settling and over the common time alone, so that the spikes outside do not count."""
    both = figures(*load_runs(*cases))
    assert both is not None
    assert (both.begin, both.end) == (2.0, 3.0)
    e, most, torque = both.rows
    assert e.first == pytest.approx(30, rel=1e-3)
    assert (e.second, most.first, most.second) == pytest.approx((40, 45, 40))
    assert (torque.first, torque.second, torque.ratio) == pytest.approx((0.002, 0.004, 2))
    done = CliRunner().invoke(app, ["compare", *map(str, cases), "--plots", "0"])
    lines = [line.split() for line in done.stdout.splitlines()]
    place = next(k for k, words in enumerate(lines) if words[:1] == ["feedback"])
    assert lines[place][-3:] == ["0.002", "0.004", "2.000"]
    assert place < next(k for k, words in enumerate(lines) if words[:1] == ["Differences,"])
    data = json.loads(
        CliRunner().invoke(app, ["compare", *map(str, cases), "--plots", "0", "--json"]).stdout
    )
    assert data["tracking"]["tau_fb_rms_Nm"]["ratio"] == pytest.approx(2)
    assert [run["name"] for run in data["runs"]] == ["adaptive feedforward", "fixed feedforward"]


def test_runs_bear_the_names_and_colours_of_their_cases(
    cases: tuple[Path, Path], tmp_path: Path
) -> None:
    adaptive, fixed = load_runs(*cases)
    assert (adaptive.colour, fixed.colour) == (COLOURS["adaptive"], COLOURS["fixed"])
    first, second = load_runs(cases[1], cases[1])
    assert first.name != second.name
    assert (first.colour, second.colour) == (COLOURS["fixed"], COLOURS["adaptive"])
    plain = [save(tracked(1e-6, 0.1), tmp_path / name / "run.h5") for name in ("x", "y")]
    first, second = load_runs(*plain)
    assert (first.name, second.name) == (str(plain[0]), str(plain[1]))
    assert first.colour != second.colour
    other, adaptive = load_runs(plain[0], cases[0])
    assert (other.name, adaptive.name) == ("run", "adaptive feedforward")
    assert other.colour != adaptive.colour == COLOURS["adaptive"]


def test_runs_without_feedback_have_no_tracking_figures(
    app: typer.Typer, runs: tuple[Path, Path]
) -> None:
    assert figures(*load_runs(*runs)) is None
    done = CliRunner().invoke(app, ["compare", *map(str, runs), "--plots", "0"])
    assert "feedback.e is not in both runs" in done.stdout


def test_ratio_of_nothing_is_no_number(app: typer.Typer, tmp_path: Path) -> None:
    paths = [save(tracked(e, e), tmp_path / f"{e:g}.h5") for e in (0.0, 1e-6)]
    both = figures(*load_runs(*paths))
    assert both is not None
    assert all(math.isnan(row.ratio) for row in both.rows)
    words = ["compare", *map(str, paths), "--plots", "0", "--json"]
    data = json.loads(CliRunner().invoke(app, words).stdout)
    assert data["tracking"]["e_rms_urad"]["ratio"] is None


def test_file_that_is_no_run_is_refused(app: typer.Typer, tmp_path: Path) -> None:
    good = save(tracked(1e-6, 0.1), tmp_path / "good.h5")
    (tmp_path / "log.csv").write_text("time,theta[1]\ns,rad\n0,1\n")
    for empty in ("empty.csv", "my.toml", "run"):
        (tmp_path / empty).write_text("")
    for name, reason in (
        ("log.csv", "neither a result of flexhex simulate.*nor a recording of the gateway"),
        ("empty.csv", "not a result"),
        ("", "is a folder"),
        ("none.csv", "no such file"),
        (
            "my.toml",
            r"my\.toml: unknown ending '\.toml': results are read from \.h5, ",
        ),
        ("run", "run: has no ending: results are read from"),
    ):
        words = ["compare", str(good), str(tmp_path / name)]
        error = CliRunner().invoke(app, words).exception
        assert isinstance(error, LogError)
        assert re.search(reason, str(error))


def test_wrong_tolerance_is_said_before_files_are_read(app: typer.Typer) -> None:
    done = CliRunner().invoke(app, ["compare", "none.h5", "none.h5", "--tol", "x"])
    assert isinstance(done.exception, UsageError)
