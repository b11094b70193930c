"""Payloads that no log announces: what they weigh, on which runs they stood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import Joint
from flexhex.diagnosis.blocks import Block
from flexhex.diagnosis.changed import normal
from flexhex.diagnosis.elsewhere import Elsewhere
from flexhex.diagnosis.payloads import Load
from flexhex.diagnosis.verdict import Changed, Estimate

Array = NDArray[np.float64]
NORMAL = 1.96
"""Standard deviations of a 95 % interval."""
LENGTHS = 0.003
"""Relative error of a machine's lengths, and so of a mass that its torques tell: one standard
deviation."""


def payload_changes(held: Joint) -> list[Changed]:
    """Every payload that only the runs show: mass and centre where the runs determine them; of
    axes without a known mechanism the parameters that it adds to."""
    made = held.bench.made
    regression = made.regression
    if held.parts:
        regression = regression.extended([part.columns for part in held.parts])
    G, b, Lambda = normal(regression, made.known)
    A = G + np.diag(Lambda)
    # columns that nothing excites stay zero
    A += 1e-10 * np.diag(np.maximum(np.diag(A), 1e-300))
    q, covariance = np.linalg.solve(A, b), np.linalg.inv(A)
    found, at = list[Changed](), len(made.known)
    for load in reversed(made.loads):
        at -= len(load.known)
        part = slice(at, at + len(load.known))
        if load.bit is not None:
            scale = made.scale[part]
            spread = covariance[part, part] * np.outer(scale, scale)
            runs = tuple(block.run.name for block in made.blocks if load.on(block.run))
            listed = _changes(load, scale * q[part], spread, made.base.reach)
            found = [*(replace(change, runs=runs) for change in listed), *found]
    return found


def elsewhere(held: Joint, blocks: Sequence[Block], drift: Joint | None) -> Elsewhere:
    """A fit seen on other runs, each with that one of the loads of its own runs that suits best."""
    made, bench = held.bench.made, held.bench
    labels = sorted({block.run.loads for block in made.blocks})
    seen = [Elsewhere(bench, [_with(b, loads) for b in blocks], drift) for loads in labels]
    if len(seen) == 1:
        return seen[0]
    left = [each.residual(held.parts, held.beta, held.q) for each in seen]
    squares = [
        [
            float(((r[b.usable] / made.torque_rms) ** 2).sum())
            for r, b in zip(own, blocks, strict=True)
        ]
        for own in left
    ]
    best = np.argmin(squares, axis=0)
    return Elsewhere(bench, [_with(b, labels[k]) for b, k in zip(blocks, best, strict=True)], drift)


def _with(block: Block, loads: int) -> Block:
    return replace(block, run=replace(block.run, loads=loads))


def _changes(load: Load, value: Array, covariance: Array, reach: float) -> list[Changed]:
    """What is said of a payload with these parameters."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    sure = np.abs(value) > NORMAL * deviation
    units = [known.unit for known in load.known]
    if "kg" not in units or not sure[units.index("kg")]:
        shown = np.flatnonzero(sure) if sure.any() else [0]
        return [_change(load.known[k].name, value[k], deviation[k], units[k]) for k in shown]
    m = units.index("kg")
    found = [_change(load.name, value[m], np.hypot(deviation[m], LENGTHS * value[m]), "kg")]
    for k in (k for k, unit in enumerate(units) if unit == "kg m"):
        centre = value[k] / value[m]
        slope = np.array([1.0, -centre]) / value[m]
        own = covariance[np.ix_([k, m], [k, m])]
        spread = float(np.sqrt(slope @ own @ slope))
        if NORMAL * spread < reach:
            name = load.known[k].name.replace(".mc_", ".c_")
            found.append(_change(name, centre, spread, "m"))
    return found


def _change(name: str, value: float, deviation: float, unit: str) -> Changed:
    ci = (float(value - NORMAL * deviation), float(value + NORMAL * deviation))
    return Changed(name, 0.0, Estimate(float(value), ci, unit))
