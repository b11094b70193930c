"""A verdict against the sealed truth. Nothing but this opens the truth.

Outcomes, one a case:
- nothing hidden: `silent` (no effect named and no gap claimed; changed parameters may be reported,
  as the machine file is indeed off by some percent), `unknown` (a gap where none is),
  `false_alarm` (an effect named, alone or in a set);
- effects of the library: see `outcome_of`;
- outside the library: `detected` (unknown, nothing named), `unnoticed` (none or changed),
  `wrong` (an effect named);
- a changed parameter: `right` (of the family that was changed), `wrong`, `missed`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from studies.generator.draw import INSIDE

VERDICTS = ("named", "set", "changed", "unknown", "none")
LARGEST_SET = 3
JOINTS = 6
SAME = 1.1
"""Largest ratio of two floors that are the same noise."""
FAMILIES = {
    "payload": ("end_effector", "payload"),
    "stiffness": ("flexure", "k_u", "k_s", "stiffness"),
    "offset": (*(f"actuator[{i}].o" for i in range(1, JOINTS + 1)), "offset"),
    "damping": (*(f"actuator[{i}].d" for i in range(1, JOINTS + 1)), "damping"),
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
    closed_gap: float | None = None
    wanted: tuple[float, ...] = ()
    notes: Mapping[str, Any] = field(default_factory=dict)
    closed_effect: float | None = None


def score(found: Mapping[str, Any], sealed: Path) -> Score:
    """Judge a verdict; ValueError when it has not the agreed form."""
    truth = json.loads(sealed.read_text(encoding="utf-8"))
    _check(found)
    hidden, effects = truth["hidden"], found["effects"]
    return Score(
        truth["seed"],
        truth["category"],
        truth["closed"],
        tuple(h["id"] for h in hidden) or tuple({c["kind"] for c in truth["changed"]}),
        tuple(h["size"] for h in hidden),
        tuple(h["observable"] for h in hidden),
        found["verdict"],
        tuple(e["id"] for e in effects),
        _outcome(truth, found),
        _closed(found.get("gap") or {}),
        tuple(h["wanted"] for h in hidden),
        {
            "hidden_axes": [h["axes"] for h in hidden],
            "named": [{"axes": e.get("axes"), "rivals": list(_rivals(e))} for e in effects],
            "changed": [c["parameter"] for c in found["changed"]],
            "gap": found.get("gap"),
        },
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


@dataclass(frozen=True)
class Hidden:
    """What a machine hides: the names that are right for it, and its joints."""

    ids: frozenset[str]
    axes: frozenset[int]

    def met(self, effect: Mapping[str, Any]) -> bool:
        """Whether a named effect is this one: its set holds it and one joint is right."""
        together = _set(effect)
        placed = bool(_axes(effect) & self.axes)
        return bool(together & self.ids) and placed and len(together) <= LARGEST_SET

    def exact(self, effect: Mapping[str, Any]) -> bool:
        """The same with all joints right and no other."""
        return self.met(effect) and _axes(effect) == self.axes


def outcome_of(hidden: Sequence[Hidden], effects: Sequence[Mapping[str, Any]]) -> str:
    """What became of effects of the library, the worst word that holds:

    `missed`: nothing is named; `wrong`: an effect is named that is not there, or on other joints
    only, or in a set of more than three; `some`: not all are named; `joints`: all are named, one
    on too many joints or too few; `set`: all are named on their joints, one of them in a set;
    `alone`: all are named on their joints and nothing else.
    """
    if not effects:
        return "missed"
    if any(not any(h.met(e) for h in hidden) for e in effects):
        return "wrong"
    if any(not any(h.met(e) for e in effects) for h in hidden):
        return "some"
    if any(not any(h.exact(e) for e in effects) for h in hidden):
        return "joints"
    return "set" if any(len(_set(e)) > 1 for e in effects) else "alone"


def outside_of(found: Mapping[str, Any]) -> str:
    """What became of an effect that the library does not have."""
    if found["effects"]:
        return "wrong"
    return "detected" if found["verdict"] == "unknown" else "unnoticed"


def _axes(effect: Mapping[str, Any]) -> frozenset[int]:
    """Joints of a named effect; none are told where it acts on the whole machine."""
    return frozenset(effect.get("axes") or range(1, JOINTS + 1))


def _outcome(truth: Mapping[str, Any], found: Mapping[str, Any]) -> str:
    category, effects = truth["category"], found["effects"]
    if category == "nothing":
        if effects:
            return "false_alarm"
        return "unknown" if found["verdict"] == "unknown" else "silent"
    if category == "changed":
        return _changed(truth, found)
    inside = [h for h in truth["hidden"] if h["id"] in INSIDE]
    if not inside:
        return outside_of(found)
    hidden = [Hidden(frozenset([h["id"]]), frozenset(h["axes"])) for h in inside]
    return outcome_of(hidden, effects)


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
