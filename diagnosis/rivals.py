"""Which effects do nearly as well as the one that was chosen, so that the runs cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.regression import Regression
from flexhex.diagnosis.scored import Found, Scored, allowed, scored

Array = NDArray[np.float64]
NEAR, CLOSE = 0.9, 0.7
"""A rival gains this share of the winner's gain: always, as nature has most effects in other forms
than the library, or when a t-test cannot tell."""
EDGE = 0.01
"""Relative distance from a bound within which a shape wants to leave it."""
LITTLE_MORE = 0.5
"""An effect that only extends another is that one while its further gains are less than this share
of the first one."""
T_APART = 2.5
"""t at which two effects' gains differ from second to second."""


def rivals(bench: Bench, winner: Found, tried: Sequence[Found]) -> tuple[str, ...]:
    """Ids of the effects that do nearly as well as the winner on its axes."""
    axes = {part.axis for part in winner.parts}
    others = [replace(f, parts=tuple(p for p in f.parts if p.axis in axes)) for f in tried]
    others = [f for f in others if f.id != winner.id and f.parts]
    if bench.across:
        # small beside the noise, which decides what gains more with more freedom or less
        return tuple(f.id for f in others if _is_rival(winner, f, 0.0, NEAR))
    near = [f for f in others if _is_rival(winner, f, CLOSE, _always(bench, winner, f))]
    return tuple(f.id for f in near if _plausible(bench, winner, f))


def clarified(bench: Bench, regression: Regression, found: Sequence[Found]) -> list[Found]:
    """Effects with those of their rivals that still do nearly as well beside all the other effects:
    in the round in which one was found these were still missing, and a rival may live on them."""
    made = []
    for effect in found:
        others = [part.columns for other in found if other is not effect for part in other.parts]
        if not effect.rivals or not others:
            made.append(effect)
            continue
        beside = regression.extended(others)
        parts = tuple(replace(p, gain=beside.gain(p.columns)) for p in effect.parts)
        asked = []
        for name in effect.rivals:
            its = (scored(bench, beside, name, part.axis) for part in effect.parts)
            asked.append(Found(name, tuple(p for p in its if allowed(bench, p)), ()))
        left = rivals(bench, replace(effect, parts=parts), [f for f in asked if f.parts])
        made.append(replace(effect, rivals=left))
    return made


def _plausible(bench: Bench, winner: Found, other: Found) -> bool:
    """Whether another effect may be a rival at all.

    One that needs more freedom to explain less only imitates, like a slow harmonic that follows
    any curved stiffness; so does one whose shape would have to leave its bounds. One that extends
    the winner always gains about as much: it is a rival unless its extension is known to be small.
    """
    mine, its = bench.effects.get(winner.id), bench.effects.get(other.id)
    if its is not None and its.effect.extends == winner.id:
        return not all(_little_more(part) for part in other.parts)
    if mine is None or its is None or other.outside > winner.outside:
        return True
    edge = any(
        not s.low * (1 + EDGE) < part.shape[s.name] < s.high * (1 - EDGE)
        for part in other.parts
        for s in bench.searched(other.id, part.axis or 0)
        if s.low > 0
    )
    return its.freedom <= mine.freedom and not edge


def _little_more(part: Scored) -> bool:
    """Whether all gains after the first are little beside it, as sure as the runs can tell."""
    spread = 2 * np.sqrt(np.maximum(np.diag(part.gain.covariance), 0.0))
    beta = np.abs(part.gain.beta)
    return bool((beta[1:] + spread[1:] < LITTLE_MORE * beta[0]).all())


def _always(bench: Bench, winner: Found, other: Found) -> float:
    """Share of the winner's gain that makes a rival without any test."""
    both = [bench.effects.get(found.id) for found in (winner, other)]
    exact = all(item is not None and item.effect.exact for item in both)
    return np.inf if exact else NEAR


def _is_rival(winner: Found, other: Found, least: float, always: float) -> bool:
    """Whether another effect does nearly as well; least, always: shares of the winner's gain that
    it must have to be asked, and that make it one without a test."""
    gained, reached = winner.outside, other.outside
    if reached < least * gained:
        return False
    if reached >= always * gained:
        return True
    apart = _clusters(winner) - _clusters(other)
    apart = apart[apart != 0]
    spread = apart.std(ddof=1) / np.sqrt(len(apart)) if len(apart) > 2 else np.inf
    return bool(apart.mean() < T_APART * spread)


def _clusters(found: Found) -> Array:
    return np.asarray(sum(part.gain.by_cluster for part in found.parts))
