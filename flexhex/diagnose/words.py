"""A diagnosis in sentences, for an engineer at the machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.changes import carriers, other_values
from flexhex.diagnose.numbers import listed, number, percent
from flexhex.diagnose.rests import sizes_of, unexplained, verb
from flexhex.diagnose.sizes import sizes
from flexhex.diagnose.titles import capital, phrase, where
from flexhex.diagnosis.prepare import ONE_TRAJECTORY
from flexhex.diagnosis.result.naming import by_name
from flexhex.diagnosis.result.rest import UNCONFIRMED
from flexhex.diagnosis.result.verdict import LARGE, WORSE, Diagnosis, Named, Residual, rms

Array = NDArray[Any]
UNNAMED = ("unknown", "cannot tell")
"""Verdicts before which it is said that the model may not be this machine's."""
TOLD = 0.02
"""Share of an axis' torque from which what an inexact form may leave is said with the verdict;
else in a note."""
COUNTED_FROM = 8
"""Answers of the study from which on their share says something."""


def explained(residual: Residual) -> float:
    """Fraction of the repeatable residual's mean square that all effects explain; NaN: unknown."""
    before, after = rms(residual.repeatable), rms(residual.repeatable_after)
    return 1 - (after / before) ** 2 if before > 0 else math.nan


def residual_name(residual: Residual) -> str:
    """What effects explain: without repeated runs the repeatable part is not known."""
    return "the repeatable residual" if np.isfinite(residual.repeatable).any() else "the residual"


def amount(residual: Residual, values: Array, axes: Array | None = None) -> str:
    """RMS over axes (from 0; all) with unit: `0.05 N m`, `0.05 N m and 2 N` where axes differ."""
    at = np.arange(len(residual.units)) if axes is None else axes
    parts = []
    for unit in dict.fromkeys(residual.units[i] for i in at):
        own = [i for i in at if residual.units[i] == unit]
        parts.append(f"{number(rms(values[own]))} {unit}")
    return listed(parts)


def verdict(diagnosis: Diagnosis) -> str:
    """The answer in one or two plain sentences, what runs carried, and how sure that is."""
    sentences = [SENTENCES[diagnosis.verdict](diagnosis), *carriers(diagnosis)]
    if diagnosis.doubt and diagnosis.verdict in UNNAMED:
        sentences.insert(0, _doubted(diagnosis.doubt))
    sure = diagnosis.confidence
    if sure and sure.of >= COUNTED_FROM:
        counts = f"{sure.right} of {sure.of} such answers in the study were right"
        sentences.append(f"Confidence {percent(sure.share)}, as {counts} (Laplace's rule).")
    if diagnosis.doubt and diagnosis.verdict not in UNNAMED:
        first, _, asked = diagnosis.doubt.partition(". ")
        sentences.append(f"But the model may not be this machine's: {first}{'.' * bool(asked)}")
    return " ".join(sentences)


def _doubted(doubt: str) -> str:
    """The doubt itself, without what it asks: nothing else is worth a thought before."""
    return f"{capital(doubt.partition('. ')[0].rstrip('?'))}: settle that first."


def _named(diagnosis: Diagnosis) -> str:
    share = explained(diagnosis.residual)
    if len(diagnosis.effects) == 1:
        (effect,) = diagnosis.effects
        share = effect.share if math.isfinite(effect.share) else share
        verb = "have" if len(effect.axes) > 1 else "has"
        text = f"{capital(where(effect.axes))} {verb} {phrase(effect.id)}{sizes(effect)}"
        text += " that the model lacks"
    else:
        parts = [f"{phrase(e.id)} on {where(e.axes)}" for e in diagnosis.effects]
        text = f"The model lacks {len(parts)} effects: {listed(parts)}"
    if math.isfinite(share):
        subject = "it explains" if len(diagnosis.effects) == 1 else "together they explain"
        there = " there" if len(diagnosis.effects) == 1 and _beside(diagnosis) else ""
        text += f"; {subject} {percent(share)} of {residual_name(diagnosis.residual)}{there}"
    more = (*_held_out(diagnosis), *_beside(diagnosis), *other_values(diagnosis))
    return " ".join([f"{text}.", *more])


def _held_out(diagnosis: Diagnosis) -> list[str]:
    """Where what is named explains less than half of the residual of held-out runs.

    A torque that acts there adds its square to the residual, or takes about as much from it. So one
    that changes the RMS by less than 2 % is below a fifth of the residual: these runs do not excite
    it. An RMS of a thousand rows is not known better than that.
    """
    residual, axes = diagnosis.residual, {a - 1 for e in diagnosis.effects for a in e.axes}
    held_out, at = residual.held_out, np.array(sorted(axes), dtype=int)
    if not len(at) or not {"before", "after"} <= held_out.keys():
        return []
    before, after = held_out["before"], held_out["after"]
    noise = held_out.get("non_repeatable", residual.non_repeatable)
    # relative, as axes may differ in unit
    squares = [float(((v / residual.torque)[at] ** 2).sum()) for v in (before, after, noise)]
    if not squares[1] - squares[2] > (squares[0] - squares[2]) / 2 > 0:
        return []
    left, whole = (amount(residual, v, at) for v in (after, before))
    if squares[0] < WORSE**2 * squares[1] < WORSE**4 * squares[0]:
        it = "it" if len(diagnosis.effects) == 1 else "them"
        return [f"The held-out runs hardly show {it}: {whole} RMS before, {left} after."]
    text = f"{left} RMS of {whole} remains"
    worse = f"it is worse: {left} RMS remains, {whole} before"
    return [f"On the held-out runs {worse if squares[1] > squares[0] else text}."]


def _ambiguous(diagnosis: Diagnosis) -> str:
    sentences = []
    for e in (_on(e, e.open) for e in diagnosis.effects if e.rivals):
        names = listed([phrase(e.id) + sizes(e), *(phrase(name) for name in e.rivals)], "or")
        verb = "lack" if len(e.axes) > 1 else "lacks"
        one = "either" if len(e.rivals) == 1 else "one of these:"
        text = f"{capital(where(e.axes))} {verb} {one} {names}; these runs do not distinguish them."
        sentences.append(text)
    rest = [(e, tuple(a for a in e.axes if a not in e.open)) for e in diagnosis.effects]
    sure = [f"{phrase(e.id)} on {where(axes)}" for e, axes in rest if axes or not e.rivals]
    if sure:
        sentences.append(f"Identified: {listed(sure)}.")
    return " ".join([*sentences, *_beside(diagnosis), *other_values(diagnosis)])


def _on(effect: Named, axes: Sequence[int]) -> Named:
    """An effect as if it were on these of its axes alone; none: as it is."""
    if not axes:
        return effect
    parts = tuple(part for part in effect.parts if part[0] in axes)
    return replace(effect, axes=tuple(axes), parameters=by_name(parts), parts=parts)


def _changed(diagnosis: Diagnosis) -> str:
    return " ".join([_undecided(diagnosis) or "No effect is missing.", *other_values(diagnosis)])


def _beside(diagnosis: Diagnosis) -> list[str]:
    """What remains beside all that is named, on axes whose effects do not leave it."""
    rests = [rest for rest in diagnosis.remains if not rest.form]
    within = [rest for rest in diagnosis.remains if rest.form and rest.share > TOLD]
    said = []
    if rests:
        said = [f"Beside that a residual {verb(rests)}: {unexplained(rests)} {sizes_of(rests)}."]
    if within:
        why = "beside what is named there, no more than an error of its form may leave"
        said.append(f"{sizes_of(within)} {verb(within)} {why}.")
    return said


def _unknown(diagnosis: Diagnosis) -> str:
    parts = [f"{phrase(e.id)} on {where(e.axes)}" for e in diagnosis.effects]
    same = f" Identified: {listed(parts)}, but more than half of the residual remains."
    same = same if parts else ""
    if diagnosis.remains:
        alone = [rest for rest in diagnosis.remains if rest.why == UNCONFIRMED]
        others = [rest for rest in diagnosis.remains if rest not in alone]
        said = [(alone, "one trajectory alone cannot name"), (others, unexplained(others))]
        texts = [f"that {what}: {sizes_of(rests)}" for rests, what in said if rests]
        return f"A residual {verb(diagnosis.remains)} {'; and one '.join(texts)}.{same}"
    residual = diagnosis.residual
    left = residual.repeatable_after
    # axes of different units compare as shares of their torque or force
    torque = np.full(len(left), rms(residual.torque)) if residual.unit else residual.torque
    size = left / torque
    worst = [i + 1 for i, v in enumerate(size) if v > 0.5 * np.nanmax(size, initial=0.0)]
    on = "on all axes" if len(worst) == len(left) > 1 else f"on {where(worst)}"
    text = f"A repeatable residual remains {on} that no effect of the library explains"
    there = np.array(worst, dtype=int) - 1
    share = rms(left[there]) / rms(residual.torque[there]) if residual.unit else rms(size[there])
    if math.isfinite(share):
        text += f": {amount(residual, left, there)} RMS, {number(100 * share, 2)} % of the torque"
    return f"{text}.{same}"


def _none(diagnosis: Diagnosis) -> str:
    if text := _undecided(diagnosis):
        return text
    residual = diagnosis.residual
    whole, noise = (amount(residual, v) for v in (residual.before, residual.non_repeatable))
    return (
        f"No effect is missing: {_fitted(residual)} leaves {whole} RMS of these runs, of which"
        f" {noise} does not repeat{_as_written(residual)}."
    )


def _undecided(diagnosis: Diagnosis) -> str:
    """Where much more is left than differs between passes, although nothing is named; or nothing.
    Of held-out runs where there are any: the parameters are not fitted to them."""
    residual, held_out = diagnosis.residual, diagnosis.residual.held_out
    torque = held_out.get("torque", residual.torque)
    left = held_out.get("after", residual.after)
    noise = np.nan_to_num(held_out.get("non_repeatable", residual.non_repeatable))
    axes = np.flatnonzero(left**2 - noise**2 > (LARGE * torque) ** 2)
    if not len(axes):
        return ""
    sizes = [f"{number(left[i])} of {number(torque[i])} {residual.units[i]}" for i in axes]
    there = "" if len(torque) == 1 else f" on {where([int(i) + 1 for i in axes])}"
    on = " of the held-out runs" if held_out else ""
    what = "one trajectory" if ONE_TRAJECTORY in diagnosis.findings else "these runs"
    return (
        f"No effect is named, but the model leaves {listed(sizes)} RMS{there}{on}, and {what}"
        " cannot tell why."
    )


def _fitted(residual: Residual) -> str:
    written = np.isfinite(residual.nominal).any()
    return "with its parameters fitted the model" if written else "the model"


def _as_written(residual: Residual) -> str:
    if not np.isfinite(residual.nominal).any():
        return ""
    return f"; with the values of its file it leaves {amount(residual, residual.nominal)}"


def _cannot(diagnosis: Diagnosis) -> str:
    text = "These runs do not decide whether the model lacks an effect."
    if not diagnosis.notes:
        return text
    why = capital(diagnosis.notes[-1])
    return f"{text} {why}" + ("" if why.endswith((".", "?")) else ".")


SENTENCES = {
    "named": _named,
    "ambiguous": _ambiguous,
    "changed": _changed,
    "unknown": _unknown,
    "none": _none,
    "cannot tell": _cannot,
}
