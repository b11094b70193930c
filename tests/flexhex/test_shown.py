"""Results of the Python interface: shown as the commands print them, and written as they write."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import flexhex
from flexhex.cli import app
from flexhex.output.parts import LONG, Sentence, Titled, html
from flexhex.output.tables import Column
from flexhex.python_words import translated
from tests.compare import assert_close
from tests.conftest import ROOT

LOGS = [str(ROOT / "examples" / "axis" / f"{name}.csv") for name in ("a1", "a2", "b1", "b2", "c1")]
RUNS, HELD_OUT = LOGS[:4], LOGS[4:]


@pytest.fixture(scope="module")
def identified() -> flexhex.Identified:
    return flexhex.identify_runs(RUNS, HELD_OUT, base="axis")


def printed(*words: str) -> str:
    """What a command prints, without blanks at the ends of lines."""
    text = CliRunner().invoke(app, [*words]).stdout
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines())


def test_identified_shows_what_the_command_prints(identified: flexhex.Identified) -> None:
    told = printed("identify", *RUNS, "--held-out", *HELD_OUT, "--base", "axis")
    assert repr(identified) == told.replace("(--all shows them)", "(all are in .parameters)")
    assert "F_c[1]" in repr(identified)


def test_diagnosis_shows_its_verdict_first_and_html_says_the_same() -> None:
    diagnosis = flexhex.diagnose_runs(RUNS, base="axis")
    first, *_ = repr(diagnosis).splitlines()
    assert first.startswith("Verdict: named. Axis 1 has Coulomb friction")
    page = diagnosis._repr_html_()
    assert first in unescape(re.sub(r"<[^>]*>", "", page))
    assert page.count("<table>") == repr(diagnosis).count("───\n") > 1
    assert "nan" not in page


def test_html_is_escaped_and_long_tables_are_folded() -> None:
    columns = (Column("a", "a < b"), Column("v", "v", "N m", ".1f"))
    rows: list[dict[str, Any]] = [{"a": "<script>", "v": 1.25}]
    page = html([Sentence("1 < 2"), Titled("T", columns, rows)])
    assert "<script>" not in page
    assert "1 &lt; 2" in page
    assert re.search(r"<th style='text-align: right; [^']*'>v \[N m\]</th>", page)
    assert re.search(r"<td style='text-align: left; [^']*'>&lt;script&gt;</td>", page)
    assert "<details>" not in page
    assert "<details><summary><b>T</b>" in html([Titled("T", columns, rows * (LONG + 1))])


def test_strips_leave_what_the_table_says(identified: flexhex.Identified) -> None:
    (strip,) = identified.strips
    assert strip.held_out
    assert identified.held_out is not None
    size = np.sqrt(np.nanmean(strip.measured**2))
    for side, share in ((strip.before, identified.held_out.file),
                        (strip.after, identified.held_out.fitted)):  # fmt: skip
        left = np.sqrt(np.nanmean((strip.measured - side) ** 2))
        assert_close(left / size, share[0], rtol=1e-9)
    assert_close(size, identified.held_out.torque[0], rtol=1e-9)


def test_files_are_those_of_the_command(identified: flexhex.Identified, tmp_path: Path) -> None:
    words = ["identify", *RUNS, "--held-out", *HELD_OUT, "--base", "axis"]
    words += ["--write", str(tmp_path / "theirs.csv"), "--next", str(tmp_path / "their-next.csv")]
    assert CliRunner().invoke(app, words).exit_code == 0
    written = flexhex.save_identified(identified, tmp_path / "out" / "ours.csv")
    assert written.files == (tmp_path / "out" / "ours.csv",)
    assert repr(written) == f"written  {tmp_path}/out/ours.csv"
    assert written.files[0].read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    planned = flexhex.plan_motion(identified, tmp_path / "next.csv")
    assert (tmp_path / "next.csv").read_bytes() == (tmp_path / "their-next.csv").read_bytes()
    assert "then" in repr(planned)
    assert planned.motion.r.shape[1] == 1


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("x.urdf", r"^path x.urdf: write .csv or .json .*; path inverse.fmu builds the inverse dy"),
        ("my model.fmu", r"^path my model.fmu: name a file like inverse.fmu"),
        ("/proc/nowhere/x.csv", r"^path /proc/nowhere/x.csv: cannot be written"),
        (3, r"^path = 3: must be a name or a path"),
    ],
)
def test_wrong_places_are_said_in_words_of_python(
    path: Any, message: str, identified: flexhex.Identified
) -> None:
    with pytest.raises(flexhex.FlexhexError, match=message):
        flexhex.save_identified(identified, path)


def test_other_mistakes_are_said(identified: flexhex.Identified) -> None:
    wrong: Any = {"base": "axis"}
    with pytest.raises(flexhex.UsageError, match=r"of type dict: must be a flexhex\.Identified"):
        flexhex.save_identified(wrong, "x.csv")
    with pytest.raises(flexhex.UsageError, match=r"^path x.txt: name a file like next.csv"):
        flexhex.plan_motion(identified, "x.txt")
    assert translated("or build all of it with --fmu") == "or build all of it as an FMU"
