"""What the first sentences say of held-out runs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexhex.diagnose.numbers import number
from flexhex.diagnose.words import verdict
from tests.flexhex.diagnoses import BASIC, NON_REPEATABLE


@pytest.mark.parametrize(("left", "reported"), [(0.3, False), (0.8, True)])
def test_what_held_out_runs_contradict_is_said_at_once(left: float, reported: bool) -> None:
    """A share of what repeats in the fitted runs says nothing of others."""
    before = BASIC.residual.held_out["before"]
    held_out = {"before": before, "after": left * before, "non_repeatable": 0.05 * before}
    text = verdict(replace(BASIC, residual=replace(BASIC.residual, held_out=held_out)))
    assert ("On the held-out runs" in text) == reported
    assert not reported or f"{number(0.8 * before[2])} N m RMS of {number(before[2])} N m" in text


def test_held_out_runs_that_become_worse_are_said_to() -> None:
    before = BASIC.residual.held_out["before"]
    held_out = {"before": before, "after": 1.5 * before, "non_repeatable": 0.05 * before}
    text = verdict(replace(BASIC, residual=replace(BASIC.residual, held_out=held_out)))
    was, now = (number(k * before[2]) for k in (1.0, 1.5))
    assert f"On the held-out runs it is worse: {now} N m RMS remains, {was} N m before." in text


@pytest.mark.parametrize(
    ("ratio", "said"),
    [(0.97, "On"), (0.99, "hardly"), (1.006, "hardly"), (1.03, "worse")],
)
def test_held_out_runs_that_hardly_change_do_not_show_an_effect(ratio: float, said: str) -> None:
    """A motion that never comes to a torque limit neither confirms nor refutes one."""
    before = 1.002 * NON_REPEATABLE
    held_out = {"before": before, "after": ratio * before, "non_repeatable": NON_REPEATABLE}
    if ratio < 1:
        held_out["non_repeatable"] = 0.1 * before
    text = verdict(replace(BASIC, residual=replace(BASIC.residual, held_out=held_out)))
    was, now = (f"{number(k * before[2])} N m" for k in (1.0, ratio))
    sentences = {
        "On": f"On the held-out runs {now} RMS of {was} remains.",
        "hardly": f"The held-out runs hardly show it: {was} RMS before, {now} after.",
        "worse": f"On the held-out runs it is worse: {now} RMS remains, {was} before.",
    }
    assert text.endswith(sentences[said])
