"""What the runs determine is accepted, what noise alone does is not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection import search
from flexhex.diagnosis.selection.bars import Bars
from flexhex.diagnosis.selection.changed import ChangedParameter
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.moments import Term
from flexhex.diagnosis.selection.scores import Score


def test_hypothesis_that_only_noise_determines_is_passed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Products between passes that have lost their sign let a fit run away."""
    scores = [Score(ChangedParameter(name, (0,), None), 50.0, np.zeros(2), 0.01) for name in "ab"]
    monkeypatch.setattr(search, "unrepeated", lambda *_: None)
    monkeypatch.setattr(search, "bars_of", lambda *_: Bars(0.0, 0.0))
    monkeypatch.setattr(
        search, "chosen", lambda m, k, own, *_: Accepted(own[0], (), 1) if own else None
    )

    def model(fit: object) -> SimpleNamespace:
        return SimpleNamespace(fit=lambda _: fit, without=lambda *_: model(fit))

    longer = {score: model(SimpleNamespace(sure=score is scores[1])) for score in scores}
    sure = model(SimpleNamespace(sure=True))
    seen = SimpleNamespace(clear=lambda *_: True)
    hypotheses: Any = SimpleNamespace(rows=SimpleNamespace(n=1), moments=sure, seen=seen)
    asked = search.Search(hypotheses, USUAL)
    monkeypatch.setattr(search.Search, "_with", lambda _, score: (longer[score], ()))
    accepted = asked.chosen_of(scores, 1)
    assert accepted is not None
    assert accepted.score is scores[1]
    assert asked.chosen_of(scores[:1], 1) is None


def test_errors_of_form_that_noise_moves_leave_a_model_sure() -> None:
    """Of two effects that are nearly alike, as friction is."""
    error, term = (Term({}, {}, np.zeros(0)) for _ in range(2))
    without = SimpleNamespace(fit=lambda _: SimpleNamespace(sure=True))
    moments: Any = SimpleNamespace(without=lambda *gone: without if gone == (error,) else None)
    assert search._sure(moments, [(), (term, error)])
