"""A verdict against the sealed truth. Nothing but this opens the truth.

Outcomes, one a case:
- nothing hidden: `right` (none, or changed parameters: the file is indeed off by some percent),
  `unknown` (a gap where none is), `false_alarm` (an effect named, alone or in a set);
- one effect: `alone` (named, no rival, nothing else), `set` (it is in a set of at most three,
  nothing else), `wrong` (any effect named that is not there, the right name on wrong joints
  only, or too large a set), `missed` (nothing named);
- two effects or more: `both` (all), `some`, `wrong`, `missed`;
- outside the list: `right` (unknown, none or changed), `wrong` (an effect named);
- a changed parameter: `right` (of the family that was changed), `wrong`, `missed`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from studies.generator.draw import INSIDE

VERDICTS = ("named", "set", "changed", "unknown", "none")
LARGEST_SET = 3
SAME = 1.1
"""Largest ratio of two floors that are the same noise."""
FAMILIES = {
    "payload": ("end_effector", "payload"),
    "stiffness": ("flexure", "k_u", "k_s", "stiffness"),
    "offset": ("o[", "actuator.o", "offset"),
    "damping": ("d[", "actuator.d", "damping"),
}
"""How the name of a changed parameter may begin, by what was changed."""


@dataclass(frozen=True)
class Score:
    """What became of one case; sizes and observable are shares of torque RMS, truth's order.

    `closed_gap`: share of the gap above the floor that the change took away on locked runs;
    `closed_effect`: share of the gap that the effect itself had made, see `beside`.
    """

    seed: int
    category: str
    closed: bool
    truth: tuple[str, ...]
    sizes: tuple[float, ...]
    observable: tuple[float, ...]
    verdict: str
    named: tuple[str, ...]
    outcome: str
    axes_right: bool | None = None
    closed_gap: float | None = None
    wanted: tuple[float, ...] = ()
    notes: Mapping[str, Any] = field(default_factory=dict)
    closed_effect: float | None = None


def score(found: Mapping[str, Any], sealed: Path) -> Score:
    """Judge a verdict; ValueError when it has not the agreed form."""
    truth = json.loads(sealed.read_text(encoding="utf-8"))
    _check(found)
    hidden, effects = truth["hidden"], found["effects"]
    outcome, axes = _outcome(truth, found)
    return Score(
        truth["seed"],
        truth["category"],
        truth["closed"],
        tuple(h["id"] for h in hidden) or tuple({c["kind"] for c in truth["changed"]}),
        tuple(h["size"] for h in hidden),
        tuple(h["observable"] for h in hidden),
        found["verdict"],
        tuple(e["id"] for e in effects),
        outcome,
        axes,
        _closed(found.get("gap") or {}),
        tuple(h["wanted"] for h in hidden),
        {"rivals": [list(_rivals(e)) for e in effects], "gap": found.get("gap")},
    )


def beside(judged: Score, twin: Mapping[str, Any]) -> Score:
    """The score with `closed_effect`: what the base model leaves of the same runs without the
    effect (`twin`, a verdict on these) is no part of the gap that naming it can close.

    As `closed_gap` where the twin's floor is another: then the gap stands between command and
    report, or a drift was taken off the runs, and the twin's is no measure of it.
    """
    gap, bare = judged.notes["gap"], twin["gap"]
    if judged.closed_gap is None or not 1 / SAME < gap["floor"] / bare["floor"] < SAME:
        return replace(judged, closed_effect=judged.closed_gap)
    made = gap["before"] - bare["before"]
    closed = (gap["before"] - gap["after"]) / made if made > 0 else None
    return replace(judged, closed_effect=closed)


def _check(found: Mapping[str, Any]) -> None:
    if found.get("verdict") not in VERDICTS:
        raise ValueError(f"verdict {found.get('verdict')!r}: one of {', '.join(VERDICTS)}")
    for key in ("effects", "changed"):
        if not isinstance(found.get(key), list):
            raise ValueError(f"{key}: a list is wanted, not {found.get(key)!r}")
    if any("id" not in effect for effect in found["effects"]):
        raise ValueError("effects: each needs an id")
    if found["verdict"] in ("named", "set") and not found["effects"]:
        raise ValueError(f"verdict {found['verdict']!r} without an effect")


def _rivals(effect: Mapping[str, Any]) -> tuple[str, ...]:
    """Identifiers of the rivals, which may stand there bare or as objects with an id."""
    listed = effect.get("rivals") or []
    return tuple(r if isinstance(r, str) else str(r["id"]) for r in listed)


def _set(effect: Mapping[str, Any]) -> frozenset[str]:
    return frozenset((effect["id"], *_rivals(effect)))


def _meets(effect: Mapping[str, Any], hidden: Mapping[str, Any]) -> bool:
    """Whether a named effect is the hidden one: its set holds it and a joint is right."""
    axes = effect.get("axes")
    placed = not axes or bool(set(axes) & set(hidden["axes"]))
    return hidden["id"] in _set(effect) and placed and len(_set(effect)) <= LARGEST_SET


def _outcome(truth: Mapping[str, Any], found: Mapping[str, Any]) -> tuple[str, bool | None]:
    category, effects, hidden = truth["category"], found["effects"], truth["hidden"]
    if category == "nothing":
        if effects:
            return "false_alarm", None
        return ("unknown" if found["verdict"] == "unknown" else "right"), None
    if category == "changed":
        return _changed(truth, found), None
    named = [h for h in hidden if h["id"] in INSIDE]
    if not named:
        return ("wrong" if effects else "right"), None
    if not effects:
        return "missed", None
    met = [h for h in named if any(_meets(e, h) for e in effects)]
    if not met or any(not any(_meets(e, h) for h in named) for e in effects):
        return "wrong", None
    axes = all(any(_exact(e, h) for e in effects) for h in met)
    if len(hidden) > 1:
        return ("both" if len(met) == len(named) else "some"), axes
    return ("set" if any(len(_set(e)) > 1 for e in effects) else "alone"), axes


def _exact(effect: Mapping[str, Any], hidden: Mapping[str, Any]) -> bool:
    return _meets(effect, hidden) and set(effect.get("axes") or ()) == set(hidden["axes"])


def _changed(truth: Mapping[str, Any], found: Mapping[str, Any]) -> str:
    """A changed parameter counts as found when one of its family is told; the others, which are
    a few percent off, may be told too. An effect named beside it is wrong."""
    kinds = {c["kind"] for c in truth["changed"]}
    if [e for e in found["effects"] if e["id"] not in kinds]:
        return "wrong"
    told = [str(c["parameter"]) for c in found["changed"]] + [e["id"] for e in found["effects"]]
    starts = tuple(start for kind in kinds for start in FAMILIES[kind])
    if any(name.startswith(start) for name in told for start in starts):
        return "right"
    return "wrong" if found["changed"] else "missed"


def _closed(gap: Mapping[str, Any]) -> float | None:
    """(before - after) / (before - floor), the part that could be closed; None without a gap."""
    try:
        before, after, floor = (float(gap[k]) for k in ("before", "after", "floor"))
    except (KeyError, TypeError, ValueError):
        return None
    return (before - after) / (before - floor) if before > 1.001 * floor else None
