"""A payload that all runs carry answers a doubt, also on a body that has no mass in the file."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.result import laden
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Changed


@pytest.mark.parametrize(("still", "answer"), [("", True), ("twice as large", False)])
def test_payload_on_a_body_without_mass_answers_a_doubt(
    still: str, answer: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(laden, "doubtful", lambda base, runs: still)
    base: Any = SimpleNamespace(payload=(0,), linear=(Known("tool.m", "kg", 0.0, 1.0, "tool.m"),))
    heavier = Changed("tool.m", 0.0, Estimate(1.0, (0.9, 1.1), "kg"))
    assert laden.answered(base, [heavier], []) == answer
