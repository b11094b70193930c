"""How often each verdict was right: counted as the study scores; what the package says of it."""

from __future__ import annotations

from typing import Any

import pytest

from flexhex.diagnosis.result.confidence import Confidence
from results.reliability import counts, written
from results.render import COUNTS, content


def case(verdict: str, outcome: str, category: str = "single", alone: bool = False) -> Any:
    return {"verdict": verdict, "outcome": outcome, "category": category, "alone": alone}


def test_right_answers_are_counted_by_verdict() -> None:
    result = counts(
        [
            case("named", "right"),
            case("named", "wrong"),
            case("named", "all+wrong", "pair"),
            case("named", "right", alone=True),
            case("ambiguous", "ambiguous"),
            case("unknown", "detected", "outside"),
            case("unknown", "unknown"),
            case("none", "silent", "nothing"),
            case("none", "missed"),
            case("changed", "right", "changed"),
            case("changed", "silent"),
            case("cannot tell", "silent"),
        ]
    )
    wanted = {
        "named": (1, 3),
        "ambiguous": (1, 1),
        "unknown": (1, 2),
        "none": (1, 2),
        "changed": (1, 2),
    }
    assert result == {name: {"right": a, "of": b} for name, (a, b) in wanted.items()}


def test_package_says_what_the_results_file_says() -> None:
    study = content("hidden_effects")
    if study is None:
        pytest.fail("results/hidden_effects.json is missing: make results-studies")
    assert COUNTS.read_text(encoding="utf-8") == written(study["results"])


@pytest.mark.parametrize(
    ("right", "of", "share"), [(0, 0, 0.5), (9, 10, 10 / 12), (10, 10, 11 / 12)]
)
def test_few_answers_are_not_sure(right: int, of: int, share: float) -> None:
    assert Confidence(right, of).share == pytest.approx(share)
