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

from flexhex.diagnose.next import Asked
from flexhex.diagnose.numbers import measured, number, percent
from flexhex.diagnose.view import closed, diagnosis_json, effect_rows, gap_rows, print_diagnosis
from flexhex.diagnose.words import listed, phrase, verdict
from flexhex.diagnosis.confidence import Confidence
from flexhex.diagnosis.verdict import VERDICTS, Diagnosis, Estimate, Named
from flexhex.fmus.common.effects import library
from tests.flexhex.diagnoses import (
    BASIC,
    CANNOT,
    CHANGED,
    EXAMPLES,
    NAMED,
    coulomb,
    estimate,
    gap,
)

ASKED = Asked(("flexhex", "diagnose", "run 1.csv", "--locked", "run9.csv"))
SENTENCES = {
    "named": "Axis 3 has Coulomb friction of 0.050 ± 0.003 N m that the model lacks; it explains"
    " 93 % of the repeatable residual.",
    "pair": "The model lacks 2 effects: Coulomb friction on axes 2 and 4 and a cogging harmonic on"
    " axis 5; together they explain 94 % of the repeatable residual. Parameters that deviate from"
    " the machine file: end_effector.m is 3.71 ± 0.10 kg, not 3.20 kg.",
    "set": "Axis 3 lacks one of these: Coulomb friction, Stribeck friction or a second hysteresis;"
    " these runs do not distinguish them.",
    "changed": "No effect is missing. Parameters that deviate from the machine file: end_effector.m"
    " is 3.71 ± 0.10 kg, not 3.20 kg.",
    "unknown": "A repeatable residual remains on axis 4 that no effect of the library explains:"
    " 0.0290 N m RMS, 1.3 % of the torque.",
    "none": "No effect is missing: the model explains these runs down to the non-repeatable"
    " residual (0.00900 N m RMS, of which 0.00900 N m is non-repeatable).",
    "payload": "No effect is missing. A payload that no log announces was on run1.csv and run2.csv:"
    " payload 0.2550 ± 0.0010 kg, payload.c_z 0.0231 ± 0.0012 m.",
    "cannot tell": "These runs do not decide whether the model lacks an effect. No trajectory was"
    " run twice, so what repeats is not known.",
}


def shown(found: Diagnosis, width: int = 80) -> str:
    """What the terminal shows."""
    out = Console(file=io.StringIO(), width=width)
    print_diagnosis(found, ASKED, out)
    text = out.file.getvalue()  # type: ignore[attr-defined]
    assert isinstance(text, str)
    return text


def test_verdict_says_how_often_such_answers_were_right() -> None:
    sure = replace(NAMED, confidence=Confidence(18, 19))
    assert verdict(sure).endswith("Confidence 90 %: 18 of 19 such answers in the study were right.")
    assert sure.data()["confidence"] == pytest.approx(19 / 21)
    assert "Confidence" not in verdict(NAMED)


@pytest.mark.parametrize("name", SENTENCES)
def test_verdict_is_one_plain_sentence(name: str) -> None:
    assert verdict(EXAMPLES[name]) == SENTENCES[name]


def test_every_verdict_has_an_example_that_starts_with_its_sentence() -> None:
    assert {found.verdict for found in EXAMPLES.values()} == set(VERDICTS)
    for found in EXAMPLES.values():
        text = " ".join(shown(found).split())
        assert text.startswith(verdict(found)), text[:200]


def test_reason_that_asks_ends_as_it_does() -> None:
    asking = replace(CANNOT, notes=("other units?",))
    assert verdict(asking).endswith("lacks an effect. Other units?")
    assert verdict(replace(CANNOT, notes=())).endswith("lacks an effect.")


def test_nothing_is_said_to_repeat_where_no_run_was_repeated() -> None:
    single = replace(BASIC, gap=replace(BASIC.gap, repeat=np.full(6, np.nan)))
    assert verdict(single).endswith("it explains 93 % of the residual.")


def test_several_axes_have_their_own_sizes_and_many_a_range() -> None:
    few = verdict(replace(BASIC, effects=(coulomb((2, 4)),)))
    assert "Axes 2 and 4 have Coulomb friction of 0.050 ± 0.003 N m and 0.060 ± 0.003 N m" in few
    many = verdict(replace(BASIC, effects=(coulomb((1, 2, 4, 5)),)))
    assert "of 0.0500 to 0.0800 N m that" in many


def test_amplitudes_of_sine_and_cosine_are_one_size() -> None:
    """hypot(3, 4) = 5; other units, as those of a drift's two gains, are no pair."""
    pair = {"a": estimate(0.03, 0.001), "b": estimate(-0.04, 0.001)}
    found = replace(BASIC, effects=(Named("cogging_harmonic", "", (1,), pair),))
    assert "Axis 1 has a cogging harmonic of 0.0500 N m that" in verdict(found)
    other = {"g_t": estimate(0.03, 0.001, "1"), "g_w": estimate(0.1, 0.01, "1/N2 m2")}
    found = replace(BASIC, effects=(Named("thermal_drift", "", (1,), other),))
    assert "Axis 1 has thermal drift of the motor constant that" in verdict(found)


def test_effect_on_the_whole_machine_and_one_from_nowhere_have_sentences() -> None:
    tilt = {"tilt_x": estimate(0.003, 0.0004, "rad"), "tilt_y": estimate(0.004, 0.0004, "rad")}
    found = replace(BASIC, effects=(Named("gravity_tilt", "", (), tilt, share=0.8),))
    assert verdict(found).startswith("The machine as a whole has a tilted base of 0.00500 rad that")
    found = replace(BASIC, effects=(Named("my_own_effect", "", (2,), {}),))
    assert verdict(found).startswith("Axis 2 has my own effect that the model lacks")


def test_every_effect_of_the_library_has_a_phrase_that_reads() -> None:
    articles = {name for name in library() if phrase(name).startswith(("a ", "an "))}
    assert {"flexible_mode", "cable_force", "drive_lag", "gravity_tilt", "drive_gain"} <= articles
    assert not articles & {"coulomb_friction", "quadratic_drag", "cubic_stiffness"}
    assert phrase("encoder_eccentricity") == "an eccentric encoder ring"


@pytest.mark.parametrize(
    ("value", "half", "unit", "text"),
    [
        (0.05, 0.0031, "N m", "0.050 ± 0.003 N m"),
        (0.05, 0.0014, "N m", "0.0500 ± 0.0014 N m"),
        (3.71, 0.1, "kg", "3.71 ± 0.10 kg"),
        (36.2, 12.0, "1/rad", "36 ± 12 1/rad"),
        (0.02, 0.002, "1", "0.020 ± 0.002"),
        (2e-7, 3e-8, "rad", "(2.0 ± 0.3)e-7 rad"),
        (3.7e-5, 3e-6, "rad/N m", "(3.7 ± 0.3)e-5 rad/N m"),
        (-2e-6, 3e-4, "s", "(0 ± 3)e-4 s"),
        (0.5, math.nan, "s", "0.500 s"),
    ],
)
def test_digits_are_those_of_the_interval(value: float, half: float, unit: str, text: str) -> None:
    assert measured(estimate(value, half, unit)) == text


def test_lopsided_interval_is_given_by_its_ends() -> None:
    """In the table the unit stands in a column of its own, and nowhere else."""
    found = Estimate(0.05, (0.04, 0.09), "N m")
    assert measured(found) == "0.0500 N m (0.0400 to 0.0900 N m)"
    effect = replace(BASIC.effects[0], parameters={"F_c": found})
    (row,) = effect_rows(replace(BASIC, effects=(effect,)))
    assert row[3:5] == ("0.0500 (0.0400 to 0.0900)", "N m")


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (0.0090, "0.00900"), (1234.5, "1234"), (math.nan, "–"), (3e-9, "3.00e-09")],
)
def test_number_has_significant_digits(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("share", "text"), [(0.934, "93 %"), (0.998, "99 %"), (0.9996, "100 %"), (math.nan, "–")]
)
def test_hundred_percent_is_said_only_of_all(share: float, text: str) -> None:
    assert percent(share) == text


def test_words_are_listed() -> None:
    assert [listed([]), listed(["a"]), listed(["a", "b"]), listed(["a", "b", "c"], "or")] == [
        "",
        "a",
        "a and b",
        "a, b or c",
    ]


@pytest.mark.parametrize(
    ("before", "after", "floor", "text"),
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
def test_closed_gap_is_measured_above_the_floor(
    before: float, after: float, floor: float, text: str
) -> None:
    """(0.05^2 - 0.03^2) / (0.05^2 - 0.01^2) = 16 / 24; 16 / 25 where the floor is not known."""
    assert closed(before, after, floor) == text


def test_gap_is_that_of_the_locked_runs_where_there_are_any() -> None:
    both = gap(left=0.02)
    third = 2
    own = gap_rows(replace(BASIC, gap=replace(both, locked={})))
    assert own[third][3] == number(float(both.after[third]))
    locked = gap_rows(replace(BASIC, gap=both))
    assert locked[third][3] == number(1.05 * float(both.after[third]))
    assert len(locked) == 7, "six axes and all of them"


def test_changed_values_are_judged_against_those_of_the_machine_file() -> None:
    """Fitted parameters are what was found then: before and after would be the same."""
    nominal = number(float(CHANGED.gap.locked["nominal"][2]))
    assert gap_rows(CHANGED)[2][2] == nominal
    assert gap_rows(BASIC)[2][2] == number(float(BASIC.gap.locked["before"][2])) != nominal
    own = replace(CHANGED, gap=replace(CHANGED.gap, locked={}))
    assert gap_rows(own)[2][2] == number(float(CHANGED.gap.nominal[2]))


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
