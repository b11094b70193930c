"""Effects that may not stay: on axes that stay unexplained, or for other reasons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.answer import Joint, axis_rms, joint
from diagnosis.calibrate import Calibrated
from diagnosis.rounds import Scored

Array = NDArray[np.float64]
POOR = 0.5
"""Share of the torque's RMS that a model may leave unexplained."""
SURE = 2.0
"""Without repeats, the residual's mean square must be this much larger without an effect."""


def poor_axes(made: Calibrated, residual: Sequence[Array]) -> list[int]:
    """Axes (from 0) of which more than `POOR` of the torque is left."""
    left = axis_rms(made.blocks, residual)
    return [int(i) for i in np.flatnonzero(left > POOR * made.torque_rms)]


def kept_off(held: Joint, axes: Sequence[int]) -> Joint:
    """The fit without effects on some axes."""
    return only(held, [part for part in held.parts if part.axis not in axes])


def only(held: Joint, parts: Sequence[Scored]) -> Joint:
    """The fit with some of its parts alone."""
    kept = [tuple(p for p in e.parts if any(p is q for q in parts)) for e in held.effects]
    pairs = zip(held.effects, kept, strict=True)
    return joint(held.bench, [replace(effect, parts=own) for effect, own in pairs if own])


def believed(held: Joint, notes: list[str]) -> Joint:
    """What may be named though no trajectory was run twice, so that nobody knows the noise.

    From several trajectories an effect without which at least twice as much (mean square, not
    whitened) would be left on its axes; from one trajectory nothing.
    """
    if not held.parts:
        return held
    blocks = held.bench.made.blocks
    if len({block.run.trajectory for block in blocks}) == 1:
        suspects = ", ".join(dict.fromkeys(effect.id for effect in held.effects))
        notes.append(
            f"one run cannot tell what its noise is: {suspects} would fit, but may be chance;"
            " run it again, and another trajectory"
        )
        return joint(held.bench, [])
    for part in held.parts:
        axes = slice(None) if part.axis is None else [part.axis]
        left = (axis_rms(blocks, held.residual)[axes] ** 2).sum()
        plain = (axis_rms(blocks, _without(held, part).residual)[axes] ** 2).sum()
        if plain < SURE * left:
            rest = _without(held, part)
            if part.id not in {other.id for other in rest.parts}:
                notes.append(f"{part.id} would fit, but may be noise: no trajectory was run twice")
            return believed(rest, notes)
    return held


def _without(held: Joint, part: Scored) -> Joint:
    return only(held, [other for other in held.parts if other is not part])


def sentence(axes: Sequence[int]) -> str:
    """What is said of such axes."""
    listed = ", ".join(str(i + 1) for i in axes)
    return (
        f"more than {POOR:.0%} of the torque of axis {listed} stays unexplained by all that"
        " was found: nothing is named there"
    )
