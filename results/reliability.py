"""How often each verdict of the study was right: the counts that `diagnose` prints."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

RIGHT = ("right", "ambiguous", "silent", "detected", "all")
"""Outcomes (`studies/honest.py`) of an answer that says what is true."""


KINDS = ("named", "ambiguous", "changed", "unknown", "none")
"""Verdicts that claim something."""


def counts(cases: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Right answers and all, by verdict, of cases with repeats and several trajectories."""
    scored = [c for c in cases if not c["alone"]]
    right = Counter(c["verdict"] for c in scored if true(c))
    of = Counter(str(c["verdict"]) for c in scored if c["verdict"] in KINDS)
    return {verdict: {"right": right[verdict], "of": of[verdict]} for verdict in sorted(of)}


def true(case: Mapping[str, Any]) -> bool:
    """Whether an answer says what is true. That parameters changed is true only where they did."""
    changed = case["verdict"] != "changed" or case["category"] in ("changed", "payload")
    return case["outcome"] in RIGHT and changed


def written(results: Mapping[str, Any]) -> str:
    """The file of the package, from the study's results."""
    return json.dumps(counts(results["cases"]), indent=2) + "\n"
