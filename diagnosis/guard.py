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


def sentence(axes: Sequence[int]) -> str:
    """What is said of such axes."""
    listed = ", ".join(str(i + 1) for i in axes)
    return (
        f"more than {POOR:.0%} of the torque of axis {listed} stays unexplained, whatever is"
        " added: nothing is named there"
    )
