"""Which effect explains what repeats: one round of candidates after the other.

A candidate counts when its Wald test, robust to errors that go together within a second, passes
at 1 % of all candidates together, and when it also explains a trajectory that it was not fitted
to. Effects that do nearly as well as the best one are its rivals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.calibrate import Calibrated
from diagnosis.candidates import Bench
from diagnosis.noise import pairs
from diagnosis.regression import Columns, Gain, Regression

Array = NDArray[np.float64]
MOST = 4
"""Most effects of a diagnosis."""
LEVEL = 0.01
"""False alarms that all candidates together may raise."""
PROMISING = 25.0
"""Fall of the sum of squares below which a candidate is not looked at any further."""
LEAST_SHARE = 0.12
"""Share of what repeats that a candidate must explain on trajectories left out."""
SMALLEST = 0.0015
"""Smallest effect that is worth naming, RMS relative to the torque's."""
NEAR, CLOSE = 0.9, 0.7
"""A rival gains this share of the winner's gain: always, or when a t-test cannot tell."""
T_APART = 2.5
"""t at which two effects' gains differ from second to second."""
REFINE = 2


@dataclass(frozen=True)
class Scored:
    """An effect on one axis (None: on the whole): its best shape, what it brings, its columns."""

    id: str
    axis: int | None
    shape: dict[str, float]
    gain: Gain
    columns: Columns


@dataclass(frozen=True)
class Found:
    """An effect with the axes on which it was found, and the effects that do nearly as well."""

    id: str
    parts: tuple[Scored, ...]
    rivals: tuple[str, ...]

    @property
    def axes(self) -> tuple[int, ...]:
        """Axes from 0; nothing where it acts on the whole."""
        return tuple(part.axis for part in self.parts if part.axis is not None)


@dataclass(frozen=True)
class Round:
    """What was tried in one round: totals over axes by effect, and what was chosen."""

    tried: tuple[Found, ...]
    shares: dict[str, float]
    chosen: Found | None


Say = Callable[[str], None]


def search(bench: Bench, say: Say = lambda text: None) -> list[Round]:
    """Rounds until nothing more is found."""
    rounds: list[Round] = []
    regression = bench.made.regression
    while len(rounds) < MOST:
        say(f"effects, round {len(rounds) + 1}")
        found = one_round(bench, regression)
        rounds.append(found)
        if found.chosen is None:
            break
        regression = regression.extended([part.columns for part in found.chosen.parts])
    return rounds


def one_round(bench: Bench, regression: Regression) -> Round:
    """Score all candidates beside the columns of a regression, and choose."""
    energy = repeating(bench.made, regression.left_out)
    count = _count(bench)
    passing: dict[str, list[Scored]] = {}
    for name, axis in _places(bench):
        if not _worth(bench, energy, axis):
            continue
        scored = best(bench, regression, name, axis)
        if scored and scored.gain.p < LEVEL / count and scored.gain.outside > 0:
            passing.setdefault(name, []).append(scored)
    shares = {
        name: sum(s.gain.outside for s in parts) / max(_energy(energy, parts), 1e-300)
        for name, parts in passing.items()
    }
    tried = sorted(
        (Found(name, tuple(parts), ()) for name, parts in passing.items()),
        key=_outside,
        reverse=True,
    )
    chosen = next((f for f in tried if _large(bench, f, shares[f.id])), None)
    if chosen is not None:
        names = tuple(other.id for other in tried if _is_rival(chosen, other))
        chosen = Found(chosen.id, _lasting(bench, chosen), names)
    return Round(tuple(tried), shares, chosen)


def best(bench: Bench, regression: Regression, name: str, axis: int | None) -> Scored | None:
    """An effect on an axis at the shape that explains most; None when it explains nothing."""
    at = 0 if axis is None else axis
    grid = bench.effects[name].shapes if name in bench.effects else [{}]
    every = [bench.columns(name, at, shape) for shape in grid]
    place, k = every[0].axis, every[0].values.shape[1]
    falls = regression.falls(place, np.hstack([c.values for c in every]), k)
    top = int(np.argmax(falls))
    if falls[top] < PROMISING:
        return None
    shape, columns = _refined(bench, regression, name, at, grid[top], every[top], falls[top])
    return Scored(name, axis, shape, regression.gain(columns), columns)


def _refined(
    bench: Bench,
    regression: Regression,
    name: str,
    axis: int,
    shape: dict[str, float],
    columns: Columns,
    fall: float,
) -> tuple[dict[str, float], Columns]:
    """Halve the distance to the grid's neighbours, one nonlinear parameter after the other."""
    item = bench.effects.get(name)
    for s in item.effect.shapes if item else ():
        if len(s.grid) < 2:
            continue
        near = sorted(abs(g - shape[s.name]) for g in s.grid)[1]
        for step in near * 0.5 ** np.arange(1, REFINE + 1):
            for value in (shape[s.name] - step, shape[s.name] + step):
                if not s.low <= value <= s.high:
                    continue
                trial = bench.columns(name, axis, {**shape, s.name: float(value)})
                better, _ = regression.fall(trial)
                if better > fall:
                    shape, columns, fall = {**shape, s.name: float(value)}, trial, better
    return shape, columns


def repeating(made: Calibrated, residual: Array) -> Array:
    """Sum of squares of what repeats of a whitened residual (R,), for each axis (n,).

    Without repeats the excess over the noise that whitening assumed, an upper bound.
    """
    by_block = _by_block(made, residual)
    n = made.base.n
    total = np.zeros(n)
    found = list(pairs(made.blocks))
    for i in range(n):
        rows = sum(len(values[i]) for values in by_block)
        if found:
            products = [by_block[a][i] @ by_block[b][i] for a, b in _same_rows(made, by_block)]
            length = sum(len(by_block[a][i]) for a, _ in found)
            total[i] = rows * sum(products) / max(length, 1)
        else:
            total[i] = sum(float(values[i] @ values[i]) for values in by_block)
    return np.maximum(total, 0.0)


def _same_rows(made: Calibrated, by_block: list[list[Array]]) -> list[tuple[int, int]]:
    return [
        (a, b) for a, b in pairs(made.blocks) if len(by_block[a][0]) == len(by_block[b][0])
    ]


def _by_block(made: Calibrated, residual: Array) -> list[list[Array]]:
    """Whitened residual of each block, of each axis."""
    ends = np.cumsum([int(kept.sum()) for kept in made.kept])
    by_axis = np.split(residual, made.base.n)
    parts = [np.split(values, ends[:-1]) for values in by_axis]
    return [[parts[i][k] for i in range(made.base.n)] for k in range(len(made.blocks))]


def _places(bench: Bench) -> list[tuple[str, int | None]]:
    per_axis: list[tuple[str, int | None]] = [
        (name, axis) for axis in range(bench.n) for name in bench.effects
    ]
    return per_axis + [(name, None) for name in bench.whole]


def _count(bench: Bench) -> int:
    shapes = sum(len(item.shapes) for item in bench.effects.values())
    return bench.n * shapes + len(bench.whole)


def _worth(bench: Bench, energy: Array, axis: int | None) -> bool:
    """Whether what repeats on an axis could hold an effect that is large enough."""
    rows = len(bench.made.regression.y) / bench.n
    noise, torque = bench.made.noise, torque_rms(bench.made)
    size = np.sqrt(energy / rows) * noise.scale
    large = size > SMALLEST * torque
    return bool(large.any() if axis is None else large[axis])


def torque_rms(made: Calibrated) -> Array:
    """RMS of the torque about its mean, of each axis (n,) [N m]."""
    stacked = np.concatenate([block.run.tau.values for block in made.blocks])
    return np.asarray(np.nanstd(stacked, axis=0))


def _energy(energy: Array, parts: Sequence[Scored]) -> float:
    axes = [part.axis for part in parts]
    return float(energy.sum() if None in axes else sum(energy[a] for a in axes if a is not None))


def _outside(found: Found) -> float:
    return sum(part.gain.outside for part in found.parts)


def _large(bench: Bench, found: Found, share: float) -> bool:
    rows = len(bench.made.regression.y) / bench.n
    torque, scale = torque_rms(bench.made), bench.made.noise.scale
    for part in found.parts:
        axes = range(bench.n) if part.axis is None else [part.axis]
        typical = float(np.mean([scale[a] for a in axes])), float(np.mean([torque[a] for a in axes]))
        size = np.sqrt(max(part.gain.outside, 0.0) / (rows * len(list(axes)))) * typical[0]
        if size > SMALLEST * typical[1] and share > LEAST_SHARE:
            return True
    return False


def _lasting(bench: Bench, found: Found) -> tuple[Scored, ...]:
    """Axes on which the effect is large enough by itself."""
    kept = [
        part for part in found.parts if _large(bench, Found(found.id, (part,), ()), np.inf)
    ]
    return tuple(kept) or found.parts


def _is_rival(winner: Found, other: Found) -> bool:
    if other.id == winner.id:
        return False
    gained, reached = _outside(winner), _outside(other)
    if reached < CLOSE * gained:
        return False
    if reached >= NEAR * gained:
        return True
    apart = _clusters(winner) - _clusters(other)
    apart = apart[apart != 0]
    spread = apart.std(ddof=1) / np.sqrt(len(apart)) if len(apart) > 2 else np.inf
    return bool(apart.mean() < T_APART * spread)


def _clusters(found: Found) -> Array:
    return np.asarray(sum(part.gain.by_cluster for part in found.parts))
