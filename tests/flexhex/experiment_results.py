"""Results of the experiments, each run when a test first asks for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from flexhex.experiments import EXPERIMENTS

MINUTES = "missing"
"""The experiment that diagnoses a hexapod and builds it anew: minutes."""
NAMES = [
    pytest.param(name, marks=pytest.mark.slow) if name == MINUTES else name for name in EXPERIMENTS
]
"""All experiments, as cases of a test."""


class Results(dict[str, Any]):
    """Result by name of the experiment; `run` makes it."""

    def __init__(self, run: Callable[[str], Any]) -> None:
        super().__init__()
        self.run = run

    def __missing__(self, name: str) -> Any:
        self[name] = self.run(name)
        return self[name]
