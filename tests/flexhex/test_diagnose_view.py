"""What a diagnosis says: sentences, tables, page; every verdict reads well and needs no network."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from flexhex.diagnose.changes import allowed
from flexhex.diagnose.effects import effect_rows, undetermined
from flexhex.diagnose.next import Invocation
from flexhex.diagnose.numbers import number
from flexhex.diagnose.page import write_diagnosis
from flexhex.diagnose.sizes import sizes
from flexhex.diagnose.view import (
    closed,
    diagnosis_json,
    parameter_rows,
    print_diagnosis,
    residual_rows,
    vague,
)
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.result.estimates import Estimate, Parameter
from flexhex.diagnosis.result.verdict import VERDICTS, Diagnosis, Tolerated
from tests.flexhex.diagnoses import (
    BASIC,
    CANNOT,
    CHANGED,
    EXAMPLES,
    NAMED,
    estimate,
    residual,
)

INVOCATION = Invocation(("flexhex", "diagnose", "run 1.csv", "--held-out", "run9.csv"))


def shown(diagnosis: Diagnosis, width: int = 80) -> str:
    """What the terminal shows."""
    out = Console(file=io.StringIO(), width=width)
    print_diagnosis(diagnosis, INVOCATION, out)
    text = out.file.getvalue()  # type: ignore[attr-defined]
    assert isinstance(text, str)
    return text


def test_every_verdict_has_an_example_that_starts_with_its_sentence() -> None:
    assert {example.verdict for example in EXAMPLES.values()} == set(VERDICTS)
    for example in EXAMPLES.values():
        text = " ".join(shown(example).split())
        first = f"Verdict: {example.verdict}. {verdict(example)}"
        assert text.startswith(first), text[:200]


def test_effect_has_a_row_for_each_place() -> None:
    """Its name and share stand in the first one."""
    parts = tuple((axis, {"a": Estimate(0.1 * axis, (0.0, 1.0), "N m")}) for axis in (1, 1, 4))
    effect = replace(BASIC.effects[0], axes=(1, 4), parts=parts, share=0.5)
    rows = effect_rows(replace(BASIC, effects=(effect,)))
    assert [row[1] for row in rows] == ["axis 1", "axis 1", "axis 4"]
    assert [row[0] != "" for row in rows] == [True, False, False]
    assert [row[3] for row in rows] == ["50 %", "", ""]
    assert rows[0][2].startswith("a = 0.100 N m (")
    whole = replace(effect, axes=(), parts=())
    ((_, place, values, _),) = effect_rows(replace(BASIC, effects=(whole,)))
    assert place == "whole"
    assert all(f"{name} = " in values for name in whole.parameters)


def test_sentence_leaves_out_what_is_not_determined() -> None:
    """A mode beyond what the smoothing lets be told; a line below the table says so."""
    values = {
        "J_2": estimate(0.05, 0.01, "kg m2"),
        "f": Estimate(10.7, (-math.inf, math.inf), "Hz"),
    }
    effect = replace(BASIC.effects[0], id="flexible_mode", axes=(1,), parts=((1, values),))
    (line,) = undetermined(replace(BASIC, effects=(effect,)))
    assert line.endswith("f is not determined on axis 1 (in the fit: 10.7 Hz)")
    assert sizes(replace(effect, parameters=values)) == " of 0.050 ± 0.010 kg m²"
    known = values | {"f": Estimate(10.7, (10.0, 11.4), "Hz")}
    assert sizes(replace(effect, parameters=known)) == " of 0.050 ± 0.010 kg m² at 10.7 Hz"


def test_whole_numbers_that_mean_something_are_said_in_words() -> None:
    values = {"C": estimate(-0.19, 0.02, "N m"), "source": Estimate(2.0, (2.0, 2.0), "1")}
    values["kind"] = Estimate(3.0, (3.0, 3.0), "1")
    effect = replace(BASIC.effects[0], id="cross_coupling", axes=(1,), parts=((1, values),))
    ((_, _, told, _),) = effect_rows(replace(BASIC, effects=(effect,)))
    assert told == "C = -0.19 ± 0.02 N m, source = axis 2, kind = torque"
    assert sizes(replace(effect, parameters=values)).endswith(
        " (per SI unit of the torque of axis 2)"
    )


def test_what_tolerances_allow_is_said_with_what_it_makes(tmp_path: Path) -> None:
    """In terminal, page and JSON; beyond a few how many more there are; what they do not allow."""
    tilt = Tolerated("gravity.x", 0.0, estimate(0.0031, 0.0002, "rad"), (), 0.002, 1, 0.042)
    diagnosis = replace(BASIC, tolerated=(tilt,))
    said = (
        "No finding, as the tolerances allow it: gravity.x (the machine is tilted about this axis"
        " of its foot) is 0.0031 ± 0.0002 rad, tolerance 0.002 rad, which makes 4.2 % of the"
        " torque of axis 1."
    )
    assert allowed(diagnosis) == [said]
    console = Console(file=io.StringIO(), width=100)
    print_diagnosis(diagnosis, Invocation((), ()), console)
    assert said in console.file.getvalue()  # type: ignore[attr-defined]
    page = write_diagnosis(diagnosis, Invocation((), ()), [], tmp_path / "page.html")
    assert said in page.read_text()
    (data,) = diagnosis.data()["tolerated"]
    assert (data["parameter"], data["tolerance"], data["axis"]) == ("gravity.x", 0.002, 1)
    assert allowed(replace(BASIC, tolerated=(tilt,) * 5))[0].endswith("; 2 more, which make less.")
    far = replace(tilt, estimate=estimate(0.0081, 0.0002, "rad"))
    inside, beyond = allowed(replace(BASIC, tolerated=(tilt, far)))
    assert inside == said
    assert beyond.startswith("Beyond the tolerance, but no finding by itself: gravity.x (")
    assert not allowed(BASIC)


def test_parameter_that_is_not_determined_is_said_once_below_the_table() -> None:
    """With its axes and what it is in the fit, not in every row."""
    open_ = Estimate(4e-6, (-math.inf, math.inf), "rad")
    known, force = Estimate(2e-5, (1e-5, 3e-5), "rad"), Estimate(0.6, (0.5, 0.7), "N m")
    parts = tuple(
        (axis, {"F_c": force, "s_0": known if axis == 2 else open_}) for axis in (1, 2, 4)
    )
    effect = replace(BASIC.effects[0], id="coulomb_friction", axes=(1, 2, 4), parts=parts)
    diagnosis = replace(BASIC, effects=(effect,))
    assert ["s_0" in row[2] for row in effect_rows(diagnosis)] == [False, True, False]
    text = "Coulomb friction: s_0 is not determined on axes 1 and 4 (in the fit: 4.00e-6 rad)"
    assert undetermined(diagnosis) == [text]
    console = Console(file=io.StringIO(), width=100)
    print_diagnosis(diagnosis, Invocation((), ()), console)
    assert text in console.file.getvalue()  # type: ignore[attr-defined]
    whole = replace(effect, axes=(), parts=(), parameters={"F_c": force, "s_0": open_})
    (line,) = undetermined(replace(BASIC, effects=(whole,)))
    assert line.startswith("Coulomb friction: s_0 is not determined (in the fit")


@pytest.mark.parametrize(
    ("before", "after", "non_repeatable", "text"),
    [
        (0.05, 0.01, 0.01, "100 %"),
        (0.05, 0.005, 0.01, "100 %"),
        (0.05, 0.03, 0.01, "67 %"),
        (0.05, 0.05, 0.01, "0 %"),
        (0.05, 0.06, 0.01, "1.20 × before"),
        (0.01, 0.01, 0.01, ""),
        (math.nan, 0.01, 0.01, ""),
        (0.05, 0.03, math.nan, "64 %"),
    ],
)
def test_explained_share_is_measured_beyond_the_non_repeatable_part(
    before: float, after: float, non_repeatable: float, text: str
) -> None:
    """(0.05^2 - 0.03^2) / (0.05^2 - 0.01^2) = 16 / 24; 16 / 25 where it is not known."""
    assert closed(before, after, non_repeatable) == text


def test_residual_is_that_of_the_held_out_runs_where_there_are_any() -> None:
    both = residual(left=0.02)
    third = 2
    own = residual_rows(replace(BASIC, residual=replace(both, held_out={})))
    assert own[third][3] == number(float(both.after[third]))
    held_out = residual_rows(replace(BASIC, residual=both))
    assert held_out[third][3] == number(1.05 * float(both.after[third]))
    assert len(held_out) == 7, "six axes and all of them"


def test_changed_values_are_judged_against_those_of_the_machine_file() -> None:
    """Fitted parameters are what was found then: before and after would be the same."""
    nominal = number(float(CHANGED.residual.held_out["nominal"][2]))
    assert residual_rows(CHANGED)[2][2] == nominal
    assert (
        residual_rows(BASIC)[2][2] == number(float(BASIC.residual.held_out["before"][2])) != nominal
    )
    own = replace(CHANGED, residual=replace(CHANGED.residual, held_out={}))
    assert residual_rows(own)[2][2] == number(float(CHANGED.residual.nominal[2]))


@pytest.mark.parametrize("name", EXAMPLES)
def test_terminal_of_80_columns_cuts_nothing(name: str) -> None:
    text = shown(EXAMPLES[name])
    assert "…" not in text
    tables = [line for line in text.splitlines() if "─" in line]
    assert all(len(line) <= 80 for line in tables)


def test_terminal_holds_findings_notes_and_what_was_run() -> None:
    text = shown(NAMED, 200)
    for words in (
        *NAMED.findings,
        *NAMED.notes,
        "Rebuilt simulation of run9.csv: residual 0.0500 N m before, 0.0100 N m after",
    ):
        assert words in text
    assert "Closed loop on the machine: tracking error 26.4 µrad before, 8.50 µrad after" in text
    assert "Closed loop on the extended model (a prediction): tracking error 30.1 µrad" in text
    many = replace(NAMED, findings=tuple(f"finding {k}" for k in range(14)))
    assert "finding 9\n" in shown(many)
    assert "finding 10\n" not in shown(many)
    assert "and 4 more in the report" in shown(many)
    assert shown(CANNOT).count("no trajectory was run twice") == 0, "the verdict has said it"


@pytest.mark.parametrize("name", EXAMPLES)
def test_json_holds_no_figure_that_is_none(name: str) -> None:
    odd = replace(EXAMPLES[name], shown={"a": np.array([1.0, np.nan]), "b": np.float64(2.0)})
    data = json.loads(diagnosis_json(odd, Path("p.html")), parse_constant=pytest.fail)
    assert data["shown"] == {"a": [1.0, None], "b": 2.0}
    assert data["sentence"] == verdict(odd)


@pytest.mark.parametrize("count", [1, 3, 40])
def test_parameters_that_the_runs_do_not_determine_are_a_sentence(count: int) -> None:
    """An arm has a hundred of them."""
    names = ["friction", *(f"link_{k}.m" for k in range(count))]
    listed = [
        Parameter(((name, 1.0),), estimate(2.0, 0.1), 2.0, 0.1, name == "friction")
        for name in names
    ]
    identified = replace(EXAMPLES["none"], parameters=tuple(listed))
    assert [row[0] for row in parameter_rows(identified)] == ["friction"]
    (said,) = vague(identified)
    assert said.startswith(f"{count} of {count + 1} parameters ")
    assert ("(link_0.m" in said) == (count < 40)
    assert ("is not determined by these motions by itself" in said) == (count == 1)
    assert vague(replace(identified, parameters=tuple(listed[:1]))) == ()
    assert said in " ".join(shown(identified).split())
