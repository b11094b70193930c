"""Comparing two results: figures known beforehand, tolerances from both sides, nothing merged."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from flexhex.compare.command import compare_command
from flexhex.compare.results import (
    EQUAL,
    ONLY_FIRST,
    ONLY_SECOND,
    OUT,
    UNLIKE,
    Array,
    Comparison,
    Difference,
    Tolerance,
    compare,
    tolerances,
)
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.output.page import Part, write_page
from flexhex.output.plots import figure
from flexhex.ssp.results import Group, Result, rate_name, save

BASE = 0.25e-3
N = 400


def result(
    signals: Mapping[str, Array],
    period: int = 1,
    unit: str = "rad",
    base: float = BASE,
    meta: Mapping[str, str] | None = None,
) -> Result:
    """A result of one rate."""
    group = Group(period, base, signals, dict.fromkeys(signals, unit))
    n = len(next(iter(signals.values())))
    return Result({rate_name(period, base): group}, duration=n * period * base, meta=meta or {})


def wave() -> Array:
    """Three columns whose largest values are 1, 10 and 100."""
    t = np.arange(N) / 40
    return np.cos(t)[:, None] * [1.0, 10.0, 100.0]


def only(found: Comparison) -> Difference:
    """The one signal that was compared."""
    (difference,) = found.differences
    return difference


def test_the_same_samples_are_equal_without_tolerance() -> None:
    a, b = result({"plant.theta": wave()}), result({"plant.theta": wave()})
    found = compare(a, b, Tolerance(rtol=0))
    assert found.equal
    assert (only(found).worst, only(found).state) == (0, EQUAL)
    assert math.isnan(only(found).first)


def test_one_bit_is_seen_without_tolerance() -> None:
    changed = wave()
    changed[7, 1] = np.nextafter(changed[7, 1], np.inf)
    found = compare(result({"x": wave()}), result({"x": changed}), Tolerance(rtol=0))
    assert not found.equal
    assert (only(found).element, only(found).at) == (2, 7 * BASE)


def test_figures_are_those_of_a_known_difference() -> None:
    """A difference of 0.3 at sample 100 and -0.4 at 300 in column 2 of 3."""
    changed = wave()
    changed[100, 1] += 0.3
    changed[300, 1] -= 0.4
    d = only(compare(result({"x": wave()}), result({"x": changed})))
    assert (d.state, d.element, d.unit, d.rate) == (OUT, 2, "rad", "0.25ms")
    assert d.worst == pytest.approx(0.4, rel=1e-12)
    assert d.rms == pytest.approx(0.5 / math.sqrt(N), rel=1e-12)
    assert d.at == pytest.approx(300 * BASE)
    assert d.first == pytest.approx(100 * BASE)


@pytest.mark.parametrize(
    ("tolerance", "column", "allowed"),
    [
        (Tolerance(atol=1e-3, rtol=0), 0, 1e-3),
        (Tolerance(atol=0, rtol=1e-3), 1, 1e-2),
        (Tolerance(atol=1e-3, rtol=1e-3), 2, 0.101),
        (Tolerance(atol=9, rtol=9, signals={"x": 1e-5}), 2, 1e-5),
    ],
)
def test_tolerance_holds_from_both_sides(tolerance: Tolerance, column: int, allowed: float) -> None:
    for factor, equal in ((0.99, True), (1.01, False)):
        changed = wave()
        changed[200, column] += factor * allowed
        for pair in ((wave(), changed), (changed, wave())):
            found = compare(result({"x": pair[0]}), result({"x": pair[1]}), tolerance)
            assert found.equal is equal


def test_rates_are_never_merged() -> None:
    """Every second sample is the very same: still not compared, and not equal."""
    a, b = result({"x": wave()}), result({"x": wave()[::2]}, period=2)
    found = compare(a, b)
    assert (only(found).state, only(found).note) == (UNLIKE, "rate 0.25ms and 0.5ms")
    assert not found.equal
    assert not compare(a, b, common=True).equal


def test_equal_rates_by_other_base_steps_are_compared() -> None:
    a, b = result({"x": wave()}, period=2), result({"x": wave()}, base=2 * BASE)
    assert compare(a, b).equal


def test_other_unit_and_size_are_not_compared() -> None:
    a = result({"x": wave()})
    assert only(compare(a, result({"x": wave()}, unit="deg"))).note == "unit rad and deg"
    assert only(compare(a, result({"x": wave()[:, :2]}))).note == "size 3 and 2"


def test_missing_signal_is_said_and_counts_unless_only_common_ones_do() -> None:
    a, b = result({"x": wave(), "y": wave()}), result({"x": wave(), "z": wave()})
    found = compare(a, b)
    states = {d.signal: d.state for d in found.differences}
    assert states == {"x": EQUAL, "y": ONLY_FIRST, "z": ONLY_SECOND}
    assert not found.equal
    assert compare(a, b, common=True).equal
    nothing = compare(result({"x": wave()}), result({"z": wave()}), common=True)
    assert not nothing.equal, "nothing in common is not equal"


def test_longer_run_is_not_equal_but_its_common_time_is() -> None:
    a, b = result({"x": wave()}), result({"x": wave()[:300]})
    found = compare(a, b)
    assert (only(found).state, found.equal) == (EQUAL, False)
    assert compare(a, b, common=True).equal
    assert found.made == {"duration": ("0.1", "0.075")}


def test_nan_equals_nan_and_nothing_else() -> None:
    holed = wave()
    holed[50, 0] = np.nan
    assert compare(result({"x": holed}), result({"x": holed.copy()})).equal
    found = compare(result({"x": wave()}), result({"x": holed}), Tolerance(atol=1e9))
    assert not found.equal
    assert (only(found).worst, only(found).at) == (math.inf, 50 * BASE)


def test_worst_relative_to_its_size_comes_first() -> None:
    """A millionth of 100 is larger than a tenth of 1e-6, but matters less."""
    small, large = np.full(N, 1e-6), np.full(N, 100.0)
    a = result({"large": large, "small": small, "same": large})
    b = result({"large": large + 1e-4, "small": small + 1e-7, "same": large})
    assert [d.signal for d in compare(a, b).differences] == ["small", "large", "same"]


def test_what_made_the_runs_different_is_found() -> None:
    same = {"python": "3.11.7", "sha256 plant.fmu": "aa"}
    a = result({"x": wave()}, meta={**same, "casadi": "3.7"})
    b = result({"x": wave()}, meta={**same, "casadi": "3.8", "command": "flexhex run"})
    assert compare(a, b).made == {"casadi": ("3.7", "3.8"), "command": ("-", "flexhex run")}


@pytest.mark.parametrize("text", ["x", "x=", "=1", "x=small", ""])
def test_tolerance_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="write SIGNAL=NUMBER"):
        tolerances([text])


def test_tolerance_of_no_signal_or_below_zero_is_refused() -> None:
    a = result({"plant.theta": wave()})
    with pytest.raises(UsageError, match=r"did you mean 'plant\.theta'"):
        compare(a, a, Tolerance(signals={"plant.teta": 1.0}))
    for wrong in (-1.0, math.nan):
        with pytest.raises(UsageError, match="must be a number of at least 0"):
            compare(a, a, Tolerance(atol=wrong))
        with pytest.raises(UsageError, match="must be a number of at least 0"):
            compare(a, a, Tolerance(signals={"plant.theta": wrong}))


@pytest.fixture
def app() -> typer.Typer:
    """The command as `flexhex.cli` registers it."""
    made = typer.Typer()
    made.command("compare")(compare_command)
    made.callback()(lambda: None)
    return made


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
    found = json.loads(done.stdout)
    assert (found["equal"], found["page"]) == (False, None)
    theta, fault = found["signals"]
    assert theta["worst"] == pytest.approx(1e-4)
    assert theta["first"] == pytest.approx(100 * BASE)
    assert (fault["state"], fault["first"]) == (EQUAL, None)
    assert found["made"] == {"made": {"first": "here", "second": "</script>there"}}


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
    assert gap[-1] == pytest.approx(1e-4, rel=1e-3)
    assert "&lt;/script&gt;there" in text, "what a file says is text, not markup"
    assert not re.search(r"<(script|img|iframe)[^>]*\ssrc=|<link", text)


def test_text_in_a_plot_cannot_end_the_script(tmp_path: Path) -> None:
    drawn = {"place": figure("</script><b>", "t", "y", [])}
    path = write_page(tmp_path / "p.html", "", "", [Part("one", figures=drawn)])
    text = path.read_text(encoding="utf-8")
    assert "</script><b>" not in text
    found = re.search(r"^const figures = (.*);$", text, re.M)
    assert found
    assert json.loads(found[1])["place"]["layout"]["title"]["text"] == "</script><b>"


def test_bad_input_has_exit_code_3(app: typer.Typer, runs: tuple[Path, Path]) -> None:
    (runs[1].parent / "broken.h5").write_bytes(runs[0].read_bytes()[:900])
    for name in ("missing.h5", "broken.h5"):
        words = ["compare", str(runs[0]), str(runs[1].parent / name)]
        error = CliRunner().invoke(app, words).exception
        assert isinstance(error, LogError)
        assert error.exit_code == 3
        assert name in str(error)
