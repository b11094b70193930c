"""An answer of `flexhex diagnose --json` against a sealed truth, one outcome a case.

- `nothing`, and a payload that is announced: `silent`, `unknown`, `false_alarm`
- one effect of the library: `right` (an accepted name alone, on its axes and no other, of which
  those where it is too faint to be seen may be left out; or only parameters, one of which is
  accepted: a name that ends with a dot is the start of theirs),
  `right_name_wrong_axes`, `ambiguous` (its axes right, one of several that are called
  indistinguishable), `wrong` (another name), `missed` (nothing named; observable), `silent`
  (nothing named; too faint to be seen), `unknown` (a residual is reported without a name)
- outside the library: `detected` (unknown), `wrong` (a name), `missed` (none, changed or
  cannot tell; observable), `silent` (the same; too faint)
- several effects: `all`, `some`, `none`, with `+wrong` where another name stands beside them
- changed parameters, an unannounced payload: `right`, `wrong`, `unknown`, `missed`, `silent`
  (nothing reported of what is known to be too faint)
- `cannot_tell` where that is the verdict and something is hidden that could be seen, `refused`
  where the engine raised an error of its own, `failed` any other error or no time left

Names beside the right one count as `extra`, and make a `right` a `wrong`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from studies.honest_values import (
    FAINT,
    POSITIVE,
    SIGMAS,
    checks_of,
    closed_of,
    errors_of,
    names_of,
    predicts,
)

OBSERVABLE = 0.01
"""Share of torque RMS: something outside the library that must not be missed, and each of two
effects that are both to be found."""
MOST_INDISTINGUISHABLE = 3


@dataclass(frozen=True)
class Outcome:
    """What became of one case. Sizes as shares of torque RMS.

    errors: of every parameter that has an interval and a true value, in standard deviations of the
    interval; checks: what must be true of a plain axis, by name; confidence: as the answer gives
    it; closed: share of what effects add to the residual of the test runs, on the axes that have a
    name, that is removed; alone: nothing else than one trajectory, or no repeats, was
    there; predicts: what is named leaves less of the test runs; impossible: a value that no machine
    has was reported.
    """

    seed: int
    family: str
    machine: str
    category: str
    hidden: tuple[str, ...]
    axes: tuple[tuple[int, ...], ...]
    sizes: tuple[float, ...]
    observable: tuple[float, ...]
    outcome: str
    verdict: str
    named: tuple[tuple[str, ...], ...] = ()
    extra: int = 0
    errors: Mapping[str, float] = field(default_factory=dict)
    checks: Mapping[str, bool] = field(default_factory=dict)
    confidence: float | None = None
    closed: float | None = None
    alone: bool = False
    predicts: bool = False
    impossible: bool = False

    @property
    def covered(self) -> dict[str, bool]:
        """Whether the intervals hold the true values."""
        return {name: abs(error) <= SIGMAS for name, error in self.errors.items()}

    @property
    def visible(self) -> bool:
        """Whether everything that is hidden is of the larger class."""
        return bool(self.observable) and min(self.observable) >= FAINT


def score(
    answer: Mapping[str, Any] | None,
    truth: Mapping[str, Any],
    error: str = "",
    twin: Mapping[str, Any] | None = None,
) -> Outcome:
    """Judge an answer; None with an `error`, `refused` or `failed`, where there is none. twin: the
    residual of the same machine with nothing hidden; without one nothing of it would repeat.

    ValueError when the answer has not the agreed form.
    """
    if answer is None and error not in ("refused", "failed"):
        raise ValueError(f"error {error!r}: refused or failed where there is no answer")
    content: Mapping[str, Any] = answer or {"verdict": error, "effects": [], "changed": []}
    _check(content)
    hidden, effects = truth["hidden"], content["effects"]
    outcome = error if answer is None else _outcome(truth, content)
    spare = [e for e in effects if not any(_met(h, e) for h in hidden)]
    changed = tuple(str(c["kind"]) for c in truth["changed"])
    return Outcome(
        truth["seed"],
        truth["family"],
        truth["machine"],
        truth["category"],
        tuple(h["id"] for h in hidden) or changed,
        tuple(tuple(h["axes"]) for h in hidden),
        tuple(h["size"] for h in hidden),
        tuple(h["observable"] for h in [*hidden, *truth["changed"]] if "observable" in h),
        outcome,
        content["verdict"],
        tuple(names_of(e) for e in effects),
        len(spare),
        errors_of(hidden, effects),
        checks_of(truth, content) if truth["category"] == "plain" and answer else {},
        content.get("confidence"),
        closed_of(content, twin),
        truth["passes"] < 2 or len(truth["trajectories"]) < 3,
        predicts(content),
        any(
            POSITIVE.search(str(c["parameter"])) and c.get("to", 1.0) <= 0
            for c in content["changed"]
        ),
    )


def _check(answer: Mapping[str, Any]) -> None:
    for key, kind in (("verdict", str), ("effects", list), ("changed", list)):
        if not isinstance(answer.get(key), kind):
            raise ValueError(f"answer: {key} is {answer.get(key)!r}, wanted a {kind.__name__}")
    for effect in answer["effects"]:
        if "id" not in effect:
            raise ValueError(f"answer: effects: {effect!r} has no id")


def _met(hidden: Mapping[str, Any], effect: Mapping[str, Any]) -> bool:
    """Whether a named effect or one of its rivals is the hidden one, on one of its axes or more."""
    where = set(effect.get("axes") or hidden["axes"])
    return bool(set(names_of(effect)) & set(hidden["accept"]) and where & set(hidden["axes"]))


def _one(hidden: Mapping[str, Any], effects: Sequence[Mapping[str, Any]]) -> str:
    """How a hidden effect of the library is named: right, ambiguous, right_name_wrong_axes or ''.

    Several entries of one id count as one effect on all their axes.
    """
    accept, axes = set(hidden["accept"]), set(hidden["axes"])
    alone = [e for e in effects if set(names_of(e)) <= accept]
    several = [
        e
        for e in effects
        if set(names_of(e)) & accept and len(set(names_of(e))) <= MOST_INDISTINGUISHABLE
    ]
    for listed, word in ((alone, "right"), (several, "ambiguous")):
        where = set[int]().union(*(e.get("axes") or axes for e in listed))
        if listed and _visible(hidden) <= where <= axes:
            return word
    return "right_name_wrong_axes" if alone or several else ""


def _visible(hidden: Mapping[str, Any]) -> set[int]:
    """The axes of an effect on which it can be seen; of one that is too faint everywhere, that
    where it is the least so."""
    sizes = hidden.get("observable_per_axis")
    if sizes is None:
        return set(hidden["axes"])
    own = {axis: sizes[axis - 1] for axis in hidden["axes"]}
    return {axis for axis, size in own.items() if size >= min(FAINT, max(own.values()))}


def _outcome(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> str:
    hidden, effects = truth["hidden"], answer["effects"]
    if truth["changed"] and not all(c.get("announced") for c in truth["changed"]):
        return _changed(truth["changed"], answer)
    if not hidden:
        if effects:
            return "false_alarm"
        return "unknown" if answer["verdict"] == "unknown" else "silent"
    if not any(h["inside"] for h in hidden):
        return _outside(hidden, answer)
    if len(hidden) > 1:
        return _several(hidden, answer)
    return _single(hidden[0], answer)


def _silence(answer: Mapping[str, Any], seen: bool) -> str:
    """What it means that nothing is named."""
    if answer["verdict"] == "unknown":
        return "unknown"
    if not seen:
        return "silent"
    return "cannot_tell" if answer["verdict"] == "cannot tell" else "missed"


def _single(hidden: Mapping[str, Any], answer: Mapping[str, Any]) -> str:
    if not answer["effects"]:
        starts = tuple(name for name in hidden["accept"] if name.endswith("."))
        if any(str(c["parameter"]).startswith(starts) for c in answer["changed"]):
            return "right"
        return _silence(answer, hidden["observable"] >= FAINT)
    how = _one(hidden, answer["effects"])
    spare = [e for e in answer["effects"] if not set(names_of(e)) & set(hidden["accept"])]
    return "wrong" if spare or not how else how


def _outside(hidden: Sequence[Mapping[str, Any]], answer: Mapping[str, Any]) -> str:
    if answer["effects"]:
        return "wrong"
    word = _silence(answer, max(h["observable"] for h in hidden) >= OBSERVABLE)
    return "detected" if word == "unknown" else word


def _several(hidden: Sequence[Mapping[str, Any]], answer: Mapping[str, Any]) -> str:
    if not answer["effects"]:
        word = _silence(answer, max(h["observable"] for h in hidden) >= FAINT)
        return "none" if word == "missed" else word
    count = sum(_one(h, answer["effects"]) in ("right", "ambiguous") for h in hidden)
    every = set[str]().union(*(h["accept"] for h in hidden))
    spare = any(not set(names_of(e)) & every for e in answer["effects"])
    word = "all" if count == len(hidden) else "some" if count else "none"
    return word + ("+wrong" if spare else "")


def _changed(changed: Sequence[Mapping[str, Any]], answer: Mapping[str, Any]) -> str:
    """A change counts when one parameter of its kind is reported; an effect beside it is wrong."""
    starts = tuple(start for c in changed for start in c["accept"])
    names = [str(c.get("parameter", "")) for c in answer["changed"]]
    names += [str(e["id"]) for e in answer["effects"]]
    spare = [e for e in answer["effects"] if not str(e["id"]).startswith(starts)]
    if any(name.startswith(starts) for name in names) and not spare:
        return "right"
    if spare or answer["changed"]:
        return "wrong"
    return _silence(answer, max(c.get("observable", 1.0) for c in changed) >= FAINT)
