"""What held-out runs say of effects that nothing else confirms."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection import validated as module
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.validated import validated

OWN = {"": 1.0, "s": 0.8, "f": 0.7, "fs": 0.2}
"""What is left of the runs of the fit beside a spring and a friction."""


@pytest.mark.parametrize(
    ("held_out", "kept"),
    [
        ({"": 1.0, "s": 1.1, "f": 0.7, "fs": 0.2}, "fs"),
        ({"": 1.0, "s": 1.1, "f": 0.7, "fs": 0.9}, "f"),
        ({"": 1.0, "s": 1.1, "f": 1.2, "fs": 0.2}, ""),
    ],
    ids=["beside the friction", "not even then", "friction fails, too"],
)
def test_effect_is_asked_again_beside_those_that_held_out_runs_confirm(
    held_out: dict[str, float], kept: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The spring alone makes them worse, as it makes up for friction that is not there yet."""
    tables = {"own": OWN, "others": held_out}

    def names(accepted: list[Any]) -> str:
        return "".join(sorted(a.score.hypothesis.id for a in accepted))

    def fit(_: Any, parts: str) -> Any:
        return SimpleNamespace(residual=parts or "", parts=parts or "", beta=())

    monkeypatch.setattr(module, "grouped", lambda _, accepted: names(accepted))
    monkeypatch.setattr(module, "joint", fit)
    monkeypatch.setattr(module, "axis_rms", lambda blocks, of: np.array([tables[blocks][of]]))
    model = SimpleNamespace(torque_rms=np.ones(1), blocks="own")
    bench: Any = SimpleNamespace(model=model)
    others: Any = SimpleNamespace(blocks="others", beside=lambda parts, beta: parts or "")
    asked: Any = [
        SimpleNamespace(round=1, score=SimpleNamespace(hypothesis=SimpleNamespace(id=name, axis=0)))
        for name in "sf"
    ]
    found = validated(bench, asked, others, USUAL, [[]])
    assert names(list(found)) == kept
