"""Where the residual is: its repeatable part over angle, rates, torque, time, frequency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.jointfit.known import without_stated
from flexhex.diagnosis.result.pictured import Map
from flexhex.diagnosis.runs.noise import pairs

Array = NDArray[np.float64]
BINS, FINEST = 24, 240
"""Bins of a map; most of one over the angle, where cogging of a high order has to be seen."""
FEWEST = 12
"""Rows below which a bin is not shown."""
FILLED = 4 * FEWEST
"""Rows that a finer bin has on average."""
WAVE, FEW = 8, 3
"""Bins of the shortest wave that was found, as with one each the map would show another wave; rows
below which such a bin is not shown."""
SEGMENT = 128
"""Rows of a segment of a spectrum."""


def maps(fit: Joint) -> tuple[Map, ...]:
    """Maps of every axis, before and after the effects that were found."""
    bare = without_stated(fit.bench.model)
    before = _means(fit, bare.residual(bare.regression.q))
    after = _means(fit, fit.residual)
    listed = []
    for i, kind in enumerate(fit.bench.scales.kinds):
        moves = np.concatenate([_moves(fit, k)[:, i] for k, _ in before])
        mine = []
        for place, (name, unit) in enumerate(
            (
                (kind.position, "rad"),
                ("velocity", "rad/s"),
                ("acceleration", "rad/s2"),
                (kind.effort, "N m"),
                ("time", "s"),
            )
        ):
            over = np.concatenate([_quantity(fit, k, i, place) for k, _ in before])
            pair = [np.concatenate([v[:, i] for _, v in side]) for side in (before, after)]
            over, *pair = (values[moves] for values in (over, *pair))
            if not len(over):
                continue
            bins, fewest = _fine(fit, i, over) if place == 0 else (BINS, FEWEST)
            mine.append(_binned((i + 1, name, kind.unit(unit)), bins, fewest, over, *pair))
        mine.append(_spectrum(fit, i, before, after))
        listed += [replace(m, residual=kind.unit("N m")) for m in mine if len(m.centre)]
    return tuple(listed)


def _means(fit: Joint, residual: list[Array]) -> list[tuple[int, Array]]:
    """What passes have in common: (block, mean of residuals), or the blocks where none repeat."""
    blocks = fit.bench.model.blocks
    neighbours = list(pairs(blocks))
    if not neighbours:
        return [(k, r[b.usable]) for k, (r, b) in enumerate(zip(residual, blocks, strict=True))]
    means = []
    for a, b in neighbours:
        good = blocks[a].usable & blocks[b].usable
        means.append((a, (residual[a][good] + residual[b][good]) / 2))
    return means


def _rows(fit: Joint, k: int) -> NDArray[np.bool_]:
    """Rows of a block that are usable in its neighbouring pass, too."""
    blocks = fit.bench.model.blocks
    partner = dict(pairs(blocks)).get(k)
    mine = blocks[k].usable
    return mine if partner is None else mine & blocks[partner].usable


def _moves(fit: Joint, k: int) -> NDArray[np.bool_]:
    """Of these rows, those (rows, n) in which an axis does not rest."""
    block = fit.bench.model.blocks[k]
    return block.moves[_rows(fit, k)]


def _quantity(fit: Joint, k: int, axis: int, place: int) -> Array:
    block, good = fit.bench.model.blocks[k], _rows(fit, k)
    if place == 4:
        return np.asarray(block.at[good])
    motion, tau = block.run.motion, fit.bench.model.raw[k]
    values = (motion.theta, motion.thetad, motion.thetadd, tau)[place]
    return np.asarray(block.smooth(values[:, axis])[good])


def _fine(fit: Joint, axis: int, over: Array) -> tuple[int, int]:
    """Bins of a map over the angle, and the fewest rows of each: as fine as rows fill them, and as
    waves that were found ask."""
    orders = [p.shape["order"] for p in fit.parts if p.axis == axis and "order" in p.shape]
    waves = max(orders, default=0.0) * float(np.ptp(over)) / (2 * np.pi)
    usual = int(np.clip(len(over) // FILLED, BINS, FINEST))
    finer = min(int(WAVE * waves), len(over) // (2 * FEW))
    return (finer, FEW) if finer > usual else (usual, FEWEST)


def _binned(
    what: tuple[int, str, str], bins: int, fewest: int, over: Array, before: Array, after: Array
) -> Map:
    """what: axis, quantity and its unit; fewest: rows below which a bin is not shown."""
    low, high = (float(v) for v in np.quantile(over, [0.002, 0.998]))
    edges = np.linspace(low, high, bins + 1)
    which = np.digitize(over, edges) - 1
    kept = [b for b in range(bins) if (which == b).sum() >= fewest]
    rows = [which == b for b in kept]
    centre = np.array([(edges[b] + edges[b + 1]) / 2 for b in kept])
    one, two = (np.array([values[r].mean() for r in rows]) for values in (before, after))
    spread = np.array([before[r].std() / np.sqrt(r.sum()) for r in rows])
    return Map(*what, centre, one, two, spread)


def _spectrum(
    fit: Joint, axis: int, before: list[tuple[int, Array]], after: list[tuple[int, Array]]
) -> Map:
    """Amplitude density [N m / sqrt(Hz)] of what repeats."""
    model = fit.bench.model
    spacing = float(np.median(np.diff(model.blocks[0].at)))
    from scipy.signal import welch  # takes long to load

    sides, f = [], np.zeros(0)
    for side in (before, after):
        long = [v[:, axis] for _, v in side if len(v) >= SEGMENT]
        parts = [welch(v, 1 / spacing, nperseg=SEGMENT) for v in long]
        if not parts:
            return Map(axis + 1, "frequency", "Hz", f, f, f, f)
        f = parts[0][0]
        sides.append(np.sqrt(np.mean([p for _, p in parts], axis=0)))
    return Map(axis + 1, "frequency", "Hz", f[1:], sides[0][1:], sides[1][1:], 0 * f[1:])
