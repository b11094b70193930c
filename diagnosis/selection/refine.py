"""Shapes of an effect between the points of its grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.evidence import Tried, tried
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.survey import Step, beside, steps_of

Array = NDArray[np.float64]
HALVINGS, FLAT = 16, 0.05
"""Of the distance between shapes of a grid, at most; difference of evidence [nats] below which a
step is no more than a third of a standard deviation of the shape, as far as that is of noise."""
TIED = 0.99
"""Most of a correlation of two shapes that counts: of a larger one their widths say too little."""
GOOD = 0.5
"""Part of the best evidence from which another peak of a grid may end higher."""


def refined(
    moments: Moments,
    hypotheses: Hypotheses,
    effect: EffectHypothesis,
    fits: Mapping[Left, Tried],
    error: float,
) -> tuple[EffectHypothesis, dict[Left, Tried], float]:
    """An effect with its best shape alone, between the points of its grid: uphill in evidence from
    each peak of the grid, by half the distance to its neighbours, and half of that where no such
    step leads higher. That ends where it changes next to nothing, beside chance and beside a
    relative error of the form as large as thought, or where it lies on the parabola of the step
    before, whose top is known. No farther than to these neighbours. A step that gains no more than
    chance is not taken: a shape stays where its form is simplest. And how many such shapes there
    are between two of the grid, as a logarithm."""
    evidence = fits[None].evidence
    starts = [(effect.shapes[k], float(evidence[k])) for k in peaks(effect.shapes, evidence)]
    ends = [_uphill(moments, hypotheses, effect, start, error) for start in starts]
    best, _, widths = max(ends, key=lambda end: end[1])
    return best, tried(moments, best), _many(moments, hypotheses, best, widths)


def _many(
    moments: Moments,
    hypotheses: Hypotheses,
    effect: EffectHypothesis,
    widths: Mapping[str, tuple[float, float]],
) -> float:
    """How many shapes as wide as the evidence, a bell's, there are between two of the grid, as a
    logarithm. widths: standard deviation of each shape, the others held, and distance on the grid.
    """
    many = sum(log(far / (width * sqrt(2 * pi))) for width, far in widths.values())
    ranges, now = {s.name: (s.low, s.high) for s in hypotheses.searched(effect)}, effect.shapes[0]
    for (a, (one, _)), (b, (other, _)) in combinations(widths.items(), 2):
        places = [{a: now[a] + one, b: now[b] + way * other} for way in (1, -1)]
        ends = [{**now, **{n: float(np.clip(v, *ranges[n])) for n, v in p.items()}} for p in places]
        fits = tried(moments, hypotheses.shaped(effect, *ends), [None])[None].evidence
        # what the one may make up for in the other is more of the same
        tied = float(fits[1] - fits[0]) / 2 if np.isfinite(fits).all() else 0.0
        many += log(1 - min(abs(tied), TIED) ** 2) / 2
    return max(many, 0.0)


def peaks(shapes: Sequence[Mapping[str, float]], evidence: Array) -> list[int]:
    """Places of the shapes of a grid that have more evidence than those one step beside them, and a
    good part of what the best one has, which stands first."""
    steps = steps_of(shapes)
    at = {step: k for k, step in enumerate(steps)}

    def highest(step: Step) -> float:
        return max(-np.inf if k is None else float(evidence[k]) for k in beside(step, at))

    best = int(np.argmax(evidence))
    least = GOOD * max(float(evidence[best]), 0.0)
    high = [k for k in range(len(steps)) if evidence[k] > least]
    peaked = [k for k in high if evidence[k] > highest(steps[k])]
    return sorted({best, *peaked}, key=lambda k: -float(evidence[k]))


def _uphill(
    moments: Moments,
    hypotheses: Hypotheses,
    effect: EffectHypothesis,
    start: tuple[Mapping[str, float], float],
    error: float,
) -> tuple[EffectHypothesis, float, dict[str, tuple[float, float]]]:
    """A shape and its evidence, from those of a start on, and `widths`, see `_many`."""
    (now, evidence), searched = start, hypotheses.searched(effect)
    widths = dict[str, tuple[float, float]]()
    parabolas = dict[str, Parabola]()

    def at(name: str, *values: float) -> Array:
        # in one go, which reads the base model's columns once
        shapes = [{**now, name: value} for value in values]
        return tried(moments, hypotheses.shaped(effect, *shapes), [None])[None].evidence

    for level in range(1, HALVINGS + 1):
        steep, moved = False, True
        while moved:
            moved = False
            for shape in searched:
                name, flat = shape.name, FLAT * (1 + error**2 * max(evidence, 0.0))
                below, above = _way(effect, start[0], name)
                values = np.array([now[name] - below / 2**level, now[name] + above / 2**level])
                ends = start[0][name] - below, start[0][name] + above
                values = np.clip(np.clip(values, *ends), shape.low, shape.high)
                listed = at(name, *values.tolist())
                fall = evidence - float(listed.mean())
                if flat < fall < np.inf:
                    # a bell falls by x^2 / 2 in x standard deviations
                    step = sqrt((below**2 + above**2) / 2) / 2**level
                    widths[name] = step / sqrt(2 * fall), min(below, above)
                known = parabolas.pop(name, None)
                higher = int(np.argmax(listed))
                there, most = float(values[higher]), float(listed[higher])
                if (np.abs(listed - evidence) > flat).any():
                    as_known = known is not None and known.near(values, listed, flat)
                    steep |= not as_known
                    around = bool(values[0] < now[name] < values[1] and np.isfinite(fall))
                    if around and most <= evidence and not as_known:
                        known = Parabola.of(now[name], evidence, values, listed)
                        if known.height > evidence + flat:
                            there, most = known.top, float(at(name, known.top)[0])
                        parabolas[name] = known
                if most > evidence + FLAT:
                    now, evidence, moved = {**now, name: there}, most, True
        if not steep:
            break
    return hypotheses.shaped(effect, now), evidence, widths


@dataclass(frozen=True)
class Parabola:
    """The evidence about its top, as three values have it."""

    top: float
    height: float
    curve: float

    @staticmethod
    def of(now: float, evidence: float, values: Array, listed: Array) -> Parabola:
        """Through a value, which is the highest, and one on each side of it."""
        (a, b), (low, high) = values - now, listed - evidence
        slope, curve = (low * b / a - high * a / b) / (b - a), (high / b - low / a) / (b - a)
        return Parabola(now - slope / (2 * curve), evidence - slope**2 / (4 * curve), curve)

    def near(self, values: Array, listed: Array, flat: float) -> bool:
        """Whether others lie on it."""
        expected = self.height + self.curve * (values - self.top) ** 2
        return bool((np.abs(listed - expected) <= flat).all())


def ended(
    moments: Moments, hypotheses: Hypotheses, effect: EffectHypothesis, fits: Mapping[Left, Tried]
) -> bool:
    """Whether a shape that cannot lie beyond its range would: then this is another effect."""
    for shape in hypotheses.searched(effect):
        if shape.closed:
            other = hypotheses.shaped(effect, {**effect.shapes[0], shape.name: shape.high})
            if tried(moments, other)[None].evidence[0] >= fits[None].evidence[0]:
                return True
    return False


def _way(effect: EffectHypothesis, start: Mapping[str, float], name: str) -> tuple[float, float]:
    """Distances to the neighbours of a value on the grid; beyond its ends as far as inside."""
    values = sorted({shape[name] for shape in effect.shapes})
    place = values.index(start[name])
    below = values[place] - values[max(place - 1, 0)]
    above = values[min(place + 1, len(values) - 1)] - values[place]
    return below or above, above or below
