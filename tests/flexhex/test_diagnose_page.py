"""The report page of a diagnosis, its figures and what it says to do next."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.diagnose.next import Invocation, next_steps
from flexhex.diagnose.page import write_diagnosis
from flexhex.diagnose.plots import (
    MOST_BARS,
    candidate_bars,
    heat,
    residual_bars,
    shade,
    strip_figures,
)
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.result.pictured import Strip
from flexhex.diagnosis.result.verdict import Diagnosis
from tests.flexhex.diagnoses import (
    AMBIGUOUS,
    BASIC,
    CANNOT,
    CARRIED,
    CHANGED,
    EXAMPLES,
    NAMED,
)

INVOCATION = Invocation(("flexhex", "diagnose", "run 1.csv", "--held-out", "run9.csv"))


OVER = len({m.over for m in BASIC.maps} - {"frequency"})


def page(diagnosis: Diagnosis, folder: Path) -> tuple[str, dict[str, Any]]:
    """The page and its figures."""
    (folder / "run1.csv").write_text("x", encoding="utf-8")
    path = write_diagnosis(
        diagnosis, INVOCATION, [folder / "run1.csv", Path("gone.csv")], folder / "p.html"
    )
    text = path.read_text(encoding="utf-8")
    drawn = re.search(r"^const figures = (.*);$", text, re.M)
    assert drawn
    return text, json.loads(drawn[1])


@pytest.mark.parametrize("name", EXAMPLES)
def test_page_needs_no_network_and_says_the_verdict(name: str, tmp_path: Path) -> None:
    text, figures = page(EXAMPLES[name], tmp_path)
    assert not re.search(r"<(script|img|iframe)[^>]*\ssrc=|<link", text)
    assert verdict(EXAMPLES[name]).split(";")[0] in text
    assert re.findall(r'class="plot" id="([\w-]+)"', text) == list(figures)
    assert "2d711642b726b04401627ca9fbac32f5" in text, "SHA-256 of the run"


def test_page_draws_what_there_is(tmp_path: Path) -> None:
    _, figures = page(NAMED, tmp_path)
    expected = {"residual", "replay0", "loop", "round1", "round2", "spectrum-0"}
    assert set(figures) == expected | {f"map-{k}" for k in range(OVER)}
    assert set(page(CANNOT, tmp_path)[1]) == set()


def test_torque_over_time_has_the_unit_of_its_axis() -> None:
    """One that turns, one that slides."""
    time = np.arange(5.0)
    strips = [
        Strip("c.csv", True, k, unit, time, time, time, time) for k, unit in ((1, "N m"), (2, "N"))
    ]
    drawn = strip_figures(strips, 2)
    labels = {
        name: (
            one["layout"]["yaxis"]["title"]["text"],
            {line["meta"]["joint"] for line in one["data"]},
        )
        for name, one in drawn.items()
    }
    assert labels == {
        "strip": ("torque [N m]", {1}),
        "strip-residual": ("residual [N m]", {1}),
        "strip-2": ("force [N]", {2}),
        "strip-residual-2": ("residual [N]", {2}),
    }


def test_what_few_read_is_folded_and_stands_last(tmp_path: Path) -> None:
    text, _ = page(NAMED, tmp_path)
    folded = re.findall(r'<details class="more"><summary>(.*?)</summary>', text)
    assert folded == ["Candidates of the 2 rounds", "Files"]
    titles = re.findall(r"<h2>(.*?)</h2>", text)
    assert titles[-2:] == ["Findings in the logs", "Details"]
    assert text.index("<h2>Details</h2>") < text.index('id="round1"')


def test_page_takes_text_as_text(tmp_path: Path) -> None:
    odd = replace(NAMED, notes=("</script><b>",), findings=("<i>",))
    text, _ = page(odd, tmp_path)
    assert "&lt;/script&gt;&lt;b&gt;" in text
    assert "<i>" not in text


def test_bars_of_the_residual_are_its_figures() -> None:
    before, after, non_repeatable = (
        np.array([1.0, 2.0]),
        np.array([0.5, np.nan]),
        np.array([0.1, 0.1]),
    )
    first, second, line = residual_bars("", "N m", before, after, non_repeatable)["data"]
    assert (first["y"], second["y"], line["y"]) == ([1.0, 2.0], [0.5, None], [0.1, 0.1])
    assert len(residual_bars("", "N m", before, after)["data"]) == 2


def test_candidates_are_sorted_and_distinguished_by_colour() -> None:
    first = [c for c in BASIC.candidates if c.round == 1]
    many = first + [replace(first[-1], id=f"effect_{k}", gain=0.001 * k) for k in range(9)]
    drawn = candidate_bars(1, many)
    bars = {bar["name"]: bar for bar in drawn["data"]}
    assert bars["named"]["x"] == [930.0]
    assert bars["indistinguishable"]["y"][0].startswith("additional hysteresis,<br>axis")
    assert sum(len(bar["x"]) for bar in drawn["data"]) == MOST_BARS
    assert drawn["layout"]["yaxis"]["categoryarray"][-1] == bars["named"]["y"][0], "best on top"


def test_heat_table_colours_and_figures_are_the_shares() -> None:
    drawn = heat("", ["a", "b"], ["a", "b"], np.array([[1.0, 0.25], [0.0, math.nan]]))["layout"]
    cells = {(s["x0"] + 0.5, s["y0"] + 0.5): s["fillcolor"] for s in drawn["shapes"]}
    assert cells == {(0, 0): shade(1.0), (1, 0): shade(0.25)}
    assert [note["text"] for note in drawn["annotations"]] == ["100", "25"]
    assert [shade(v) for v in (-1.0, 0.25, 2.0)] == [f"rgba(31,111,178,{v})" for v in (0, 0.25, 1)]
    large = np.full((20, 20), 0.3) + 0.7 * np.eye(20)
    large[2, 5] = 0.92
    names = [f"effect {k}" for k in range(20)]
    notes = heat("", names, names, large)["layout"]["annotations"]
    assert [(n["x"], n["y"], n["text"]) for n in notes] == [(5, 2, "92")]


def test_candidates_of_one_name_are_one_bar() -> None:
    """The search tries an effect at several shapes: the chosen one is shown, else the best."""
    first = BASIC.candidates[0]
    listed = [
        replace(
            first, id="coulomb_friction", shape={"s_0": s}, gain=gain, chosen=chosen, rival=False
        )
        for s, gain, chosen in ((1e-6, 30.0, False), (1e-5, 29.0, True), (1e-4, 2.0, False))
    ]
    bars = candidate_bars(1, listed)["data"]
    assert [(bar["name"], bar["x"]) for bar in bars] == [("named", [29.0])]
    (bar,) = candidate_bars(1, [listed[0], listed[2]])["data"]
    assert (bar["name"], bar["x"]) == ("other", [30.0])


def test_nothing_is_applied_to_a_base_without_machine_file() -> None:
    single = replace(INVOCATION, base="axis")
    assert all("--apply" not in words for _, words in next_steps(CHANGED, single))


def test_page_says_how_large_a_candidate_is_and_what_its_nats_are(tmp_path: Path) -> None:
    text, figures = page(AMBIGUOUS, tmp_path)
    assert "3 nats are odds of 20" in text
    (hover, *_) = [bar["hovertext"][0] for bar in figures["round1"]["data"]]
    assert hover == "1.9 % of the torque"


def test_payload_of_some_runs_goes_into_their_heads_not_into_a_machine_file() -> None:
    assert [words for _, words in next_steps(CARRIED, INVOCATION)] == [""]
