"""How often an answer like this one was right on machines whose truth is known.

The counts are those of the study of hidden effects (docs/machines.md), on seeds of their own.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

COUNTS = Path(__file__).with_name("confidence.json")
"""Written by `python -m results.render` from the test seeds of results/hidden_effects.json."""


@dataclass(frozen=True)
class Confidence:
    """Answers of the study with the same verdict: how many were right, of how many."""

    right: int
    of: int

    @property
    def share(self) -> float:
        """Chance that such an answer is right: the mean of its distribution if all chances were
        equally likely before (Laplace's rule of succession)."""
        return (self.right + 1) / (self.of + 2)

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        return {"right": self.right, "of": self.of}


def confidence_of(verdict: str) -> Confidence | None:
    """Of a verdict from trajectories that were repeated, and of which one can predict another; None
    where the study has none."""
    known = _counts().get(verdict)
    return Confidence(**known) if known else None


@cache
def _counts() -> Mapping[str, Mapping[str, int]]:
    counts: dict[str, dict[str, int]] = json.loads(COUNTS.read_text(encoding="utf-8"))
    return counts
