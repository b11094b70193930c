"""What a diagnosis says in sentences: every verdict reads well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnose.titles import effort, phrase, readable
from flexhex.diagnose.view import changed_rows, residual_columns
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.prepare import ONE_TRAJECTORY
from flexhex.diagnosis.result.confidence import Confidence
from flexhex.diagnosis.result.rest import UNCONFIRMED, Rest
from flexhex.diagnosis.result.verdict import Changed, Named
from flexhex.fmus.common.effects import library
from tests.flexhex.diagnoses import (
    BASIC,
    CANNOT,
    EXAMPLES,
    NAMED,
    coulomb,
    estimate,
)

SENTENCES = {
    "named": "Axis 3 has Coulomb friction of 0.050 ± 0.003 N m that the model lacks; it explains"
    " 93 % of the repeatable residual.",
    "pair": "The model lacks 2 effects: Coulomb friction on axes 2 and 4 and a cogging harmonic on"
    " axis 5; together they explain 94 % of the repeatable residual. Parameters that deviate from"
    " the machine file: end_effector.m is 3.71 ± 0.10 kg, not 3.20 kg.",
    "ambiguous": "Axis 3 lacks one of these: Coulomb friction of 0.050 ± 0.003 N m, Stribeck"
    " friction or an additional hysteresis; these runs do not distinguish them.",
    "ambiguous on one axis": "Axis 4 lacks either Coulomb friction of 0.060 ± 0.003 N m or Stribeck"
    " friction; these runs do not distinguish them. Identified: Coulomb friction on axis 2.",
    "changed": "No effect is missing. Parameters that deviate from the machine file: end_effector.m"
    " is 3.71 ± 0.10 kg, not 3.20 kg.",
    "unknown": "A repeatable residual remains on axis 4 that no effect of the library explains:"
    " 0.0290 N m RMS, 1.3 % of the torque.",
    "none": "No effect is missing: with its parameters fitted the model leaves 0.00900 N m RMS of"
    " these runs, of which 0.00900 N m does not repeat; with the values of its file it leaves"
    " 0.0108 N m.",
    "payload": "No effect is missing. A payload that no log announces was on run1.csv and run2.csv:"
    " payload 0.2550 ± 0.0010 kg, payload.c_z 0.0231 ± 0.0012 m.",
    "cannot tell": "These runs do not decide whether the model lacks an effect. No trajectory was"
    " run twice, so what repeats is not known.",
}


def test_verdict_says_how_often_such_answers_were_right() -> None:
    sure = replace(NAMED, confidence=Confidence(18, 19))
    assert verdict(sure).endswith(
        "Confidence 90 %, as 18 of 19 such answers in the study were right (Laplace's rule)."
    )
    assert sure.data()["confidence"] == pytest.approx(19 / 21)
    assert "Confidence" not in verdict(NAMED)
    assert "Confidence" not in verdict(replace(NAMED, confidence=Confidence(1, 2))), "too few"


@pytest.mark.parametrize("name", SENTENCES)
def test_verdict_is_one_plain_sentence(name: str) -> None:
    assert verdict(EXAMPLES[name]) == SENTENCES[name]


def test_reason_that_asks_ends_as_it_does() -> None:
    asking = replace(CANNOT, notes=("other units?",))
    assert verdict(asking).endswith("lacks an effect. Other units?")
    assert verdict(replace(CANNOT, notes=())).endswith("lacks an effect.")


def test_nothing_is_said_to_repeat_where_no_run_was_repeated() -> None:
    single = replace(BASIC, residual=replace(BASIC.residual, repeatable=np.full(6, np.nan)))
    assert verdict(single).endswith("it explains 93 % of the residual.")


def test_rest_that_is_in_no_effect_stands_in_the_first_sentences() -> None:
    """The largest shares first, with what they go with; then what errors of form may leave, if it
    is worth a word."""
    rests = (
        Rest(2, 15.2, "N m", 0.11, "present and past motion"),
        Rest(3, 0.3, "N m", 0.03, form=True),
        Rest(5, 0.1, "N m", 0.008, form=True),
        Rest(4, 2.9, "N", 0.2),
    )
    text = verdict(replace(BASIC, remains=rests))
    assert text.endswith(
        " 0.30 N m (3.0 % of its torque) on axis 3 repeats beside what is named there, no more than"
        " an error of its form may leave."
    )
    text = verdict(replace(BASIC, remains=(rests[0], *rests[2:])))
    assert text.endswith(
        " it explains 93 % of the repeatable residual there. Beside that a residual repeats: no"
        " effect of the library explains 2.9 N (20 % of its force) on axis 4 and 15 N m (11 % of"
        " its torque) on axis 2, which goes with present and past motion."
    )
    unknown = replace(EXAMPLES["unknown"], remains=rests[:1])
    assert verdict(unknown) == (
        "A residual repeats that no effect of the library explains: 15 N m (11 % of its torque) on"
        " axis 2, which goes with present and past motion."
    )
    assert unknown.data()["remains"][0]["share"] == 0.11
    fitted = replace(rests[3], fitted=("coulomb_friction", "torque_offset"), fitted_share=0.83)
    assert verdict(replace(unknown, remains=(fitted,))) == (
        "A residual repeats that the library explains only in part: 2.9 N (20 % of its force) on"
        " axis 4 (of its mean square Coulomb friction and constant torque would explain 83 %)."
    )
    several = replace(fitted, fitted=("a", "b", "c", "d"))
    assert "square 4 effects together would" in verdict(replace(unknown, remains=(several,)))
    doubtful = verdict(replace(unknown, remains=(fitted,), doubt="another machine's file?"))
    assert doubtful.startswith("Another machine's file: settle that first. A residual repeats")
    alone = replace(fitted, why=UNCONFIRMED)
    assert verdict(replace(unknown, remains=(alone,))).startswith(
        "A residual repeats that one trajectory alone cannot name: 2.9 N (20 % of its force)"
    )
    assert alone.sentence().endswith(
        "mean square, but one trajectory cannot show it: record another one"
    )
    both = verdict(replace(unknown, remains=(rests[0], alone)))
    assert both.startswith("A residual repeats that one trajectory alone cannot name: 2.9 N")
    assert "; and one that no effect of the library explains: 15 N m" in both
    once = replace(fitted, repeats=False)
    left = verdict(replace(unknown, remains=(once,)))
    assert left.startswith("A residual is left that the library explains only in part")
    assert once.sentence().startswith("2.9 N on axis 4 is left; coulomb_friction, torque_offset")
    # without repeats too little was asked of the library to say that nothing of it would do
    nothing = replace(rests[0], repeats=False).sentence()
    assert nothing.startswith("15 N m on axis 2 is left, and nothing that is named explains it: it")


def test_what_no_torque_feels_of_a_payload_has_no_value() -> None:
    """Its height, on a machine whose axes are upright."""
    payload, height = EXAMPLES["payload"].changed
    unfelt = replace(height, estimate=estimate(0.0, 0.0, "m"))
    carried = replace(EXAMPLES["payload"], changed=(payload, unfelt))
    assert verdict(carried).endswith("payload 0.2550 ± 0.0010 kg.")
    assert [row[0] for row in changed_rows(carried)] == ["payload"]


def test_tilt_of_a_machine_is_told_in_words() -> None:
    tilted = replace(
        EXAMPLES["changed"], changed=(Changed("gravity.x", 0.0, estimate(0.05, 0.01, "rad")),)
    )
    assert "gravity.x (the machine is tilted about this axis of its foot) is 0.05" in verdict(
        tilted
    )


def test_several_axes_have_their_own_sizes_and_many_a_range() -> None:
    few = verdict(replace(BASIC, effects=(coulomb((2, 4)),)))
    assert "Axes 2 and 4 have Coulomb friction of 0.050 ± 0.003 N m and 0.060 ± 0.003 N m" in few
    many = verdict(replace(BASIC, effects=(coulomb((1, 2, 4, 5)),)))
    assert "of 0.0500 to 0.0800 N m that" in many


def test_amplitudes_of_sine_and_cosine_are_one_size() -> None:
    """hypot(3, 4) = 5; other units, as those of a drift's two gains, are no pair: what they mean is
    said instead."""
    pair = {"a": estimate(0.03, 0.001), "b": estimate(-0.04, 0.001)}
    diagnosis = replace(BASIC, effects=(Named("cogging_harmonic", "", (1,), pair),))
    assert "Axis 1 has a cogging harmonic of 0.0500 N m that" in verdict(diagnosis)
    other = {"g_t": estimate(0.03, 0.001, "1"), "g_w": estimate(0.1, 0.01, "1/N2 m2")}
    diagnosis = replace(BASIC, effects=(Named("thermal_drift", "", (1,), other),))
    means = "(loses 3 % after a long time and 10 % for each N2 m2 of mean square torque)"
    assert f"Axis 1 has thermal drift of the motor constant {means} that" in verdict(diagnosis)
    other["g_w"] = estimate(0.0, 0.01, "1/N2 m2")
    assert "motor constant (loses 3 % after a long time) that" in verdict(diagnosis)


def test_effect_on_the_whole_machine_and_one_from_nowhere_have_sentences() -> None:
    tilt = {"tilt_x": estimate(0.003, 0.0004, "rad"), "tilt_y": estimate(0.004, 0.0004, "rad")}
    diagnosis = replace(BASIC, effects=(Named("gravity_tilt", "", (), tilt, share=0.8),))
    assert verdict(diagnosis).startswith(
        "The machine as a whole has a tilted base of 0.00500 rad that"
    )
    diagnosis = replace(BASIC, effects=(Named("my_own_effect", "", (2,), {}),))
    assert verdict(diagnosis).startswith("Axis 2 has my own effect that the model lacks")


def test_every_effect_of_the_library_has_a_phrase_that_reads() -> None:
    articles = {name for name in library() if phrase(name).startswith(("a ", "an "))}
    assert {"flexible_mode", "cable_force", "drive_lag", "gravity_tilt", "drive_gain"} <= articles
    assert not articles & {"coulomb_friction", "quadratic_drag", "cubic_stiffness"}
    assert phrase("encoder_eccentricity") == "an eccentric encoder ring"


def test_doubt_about_the_model_stands_before_an_answer_that_names_nothing() -> None:
    """What else is to be done is worth nothing before; beside a name it stands at the end."""
    doubt = "95% stays of axis 2; less would be with 90 degrees taken from it. Unless: which file?"
    first = "95% stays of axis 2; less would be with 90 degrees taken from it: settle that first. "
    assert verdict(replace(CANNOT, doubt=doubt)) == first + SENTENCES["cannot tell"]
    assert verdict(replace(BASIC, doubt=doubt)).endswith(
        " But the model may not be this machine's: 95% stays of axis 2; less would be with 90"
        " degrees taken from it."
    )
    asking = replace(BASIC, doubt="2 times that: another file?")
    assert verdict(asking).endswith("machine's: 2 times that: another file?")


@pytest.mark.parametrize("name", ["none", "changed"])
def test_nothing_is_called_complete_that_leaves_a_fifth_of_a_torque(name: str) -> None:
    """0.5 of 2 N m on held-out runs, of which 0.009 does not repeat, is no silence."""
    example = EXAMPLES[name]
    left = np.where(np.arange(6) == 1, 0.5, 0.1)
    held_out = {**example.residual.held_out, "after": left}
    much = replace(example, residual=replace(example.residual, held_out=held_out))
    said = (
        "No effect is named, but the model leaves 0.500 of 2.00 N m RMS on axis 2 of the held-out"
        " runs, and these runs cannot tell why."
    )
    assert verdict(much).startswith(said)
    alone = replace(much, findings=(ONE_TRAJECTORY,))
    assert "and one trajectory cannot tell why." in verdict(alone)
    noisy = {**held_out, "non_repeatable": left}
    residual = replace(example.residual, held_out=noisy)
    assert verdict(replace(example, residual=residual)).startswith("No effect is missing")
    fitted = replace(example.residual, held_out={}, after=left)
    assert " RMS on axis 2, and these" in verdict(replace(example, residual=fitted))


def test_notes_have_titles_for_ids_and_keep_the_names_of_parameters() -> None:
    assert readable("coulomb_friction on axis 2, time_delay: no") == (
        "Coulomb friction on axis 2, delay of the drive: no"
    )
    same = "cogging_harmonic.a[2], my_coulomb_friction, viscous_friction[1], F_c[1]"
    assert readable(same) == same
    assert readable("it is cable_force.") == "it is cable force."


def test_axes_that_slide_have_forces() -> None:
    assert effort(["N", "N"]) == "force"
    assert effort(["N m", "N"]) == "torque or force"
    sliding = replace(
        BASIC, residual=replace(BASIC.residual, units=("N",) * len(BASIC.residual.units))
    )
    assert residual_columns(sliding.residual)[1] == "force about its mean"
    assert residual_columns(BASIC.residual)[1] == "torque about its mean"
