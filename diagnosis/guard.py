"""Effects that may not stay: on axes that stay unexplained, or for other reasons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import Joint, axis_rms, joint
from flexhex.diagnosis.blocks import torque_at
from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.payloads import GROUP
from flexhex.diagnosis.scored import Scored

Array = NDArray[np.float64]
POOR = 0.5
"""Share of the torque's RMS that a model may leave unexplained."""
TOGETHER = 0.7
"""Least correlation of a torque with the nominal model's. Measured: -0.97 with a turned sign, 0.62
with two axes exchanged; 0.89 and more with another payload, stiffness, damping or offset."""
DELAYED = 2e-4
"""Delay [s] of the reported torques that is worth a word."""
SURE = 2.0
"""Without repeats, the residual's mean square must be this much larger without an effect."""


def poor_axes(made: Calibrated, residual: Sequence[Array]) -> list[int]:
    """Axes (from 0) of which more than `POOR` of the torque is left."""
    left = axis_rms(made.blocks, residual)
    return [int(i) for i in np.flatnonzero(left > POOR * made.torque_rms)]


def strange_axes(made: Calibrated) -> list[int]:
    """Axes (from 0) whose torque does not go with that of the machine file's own parameters and
    the payloads of the fit.

    A fit may turn the sign of all inertias to please a log whose sign is turned; what it leaves
    then looks like effects.
    """
    carried = np.array([known.group == GROUP for known in made.known])
    nothing = np.where(carried, made.regression.q, 0.0)
    tau = [torque_at(b, made.base.window, made.fitted.delay) for b in made.blocks]
    left = made.residual(nothing)
    usable = [b.usable for b in made.blocks]
    seen = np.concatenate([t[m] for t, m in zip(tau, usable, strict=True)])
    model = seen - np.concatenate([r[m] for r, m in zip(left, usable, strict=True)])
    seen, model = (v - v.mean(axis=0) for v in (seen, model))
    sizes = np.linalg.norm(seen, axis=0) * np.linalg.norm(model, axis=0)
    together = (seen * model).sum(axis=0) / np.maximum(sizes, 1e-300)
    return [int(i) for i in np.flatnonzero(together < TOGETHER)]


def delayed(made: Calibrated) -> str:
    """What is said of the torques' common delay, which the fit has taken out; or nothing."""
    late = made.fitted.delay
    if abs(late) < DELAYED:
        return ""
    where = " on all axes" if made.base.n > 1 else ""
    alone = "" if made.base.n > 1 else "; a single axis does not show whether its drive is late"
    verb = "lags" if late > 0 else "leads"
    return (
        f"the torque channel {verb} the angles by {1e3 * abs(late):.2g} ms{where}; treated as"
        f" logger delay and compensated{alone}"
    )


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

    From one trajectory nothing; from several the strongest effect alone, if at least `SURE`
    times as much is left without it: what is weaker was judged against a noise that held the
    strongest one.
    """
    if not held.parts:
        return held
    blocks = held.bench.made.blocks
    suspects = ", ".join(dict.fromkeys(effect.id for effect in held.effects))
    if len({block.run.trajectory for block in blocks}) == 1:
        notes.append(
            f"one run cannot tell what its noise is: {suspects} would fit, but may be chance;"
            " run it again, and another trajectory"
        )
        return joint(held.bench, [])
    sizes = {effect.id: _size(held, effect.id) for effect in held.effects}
    strongest = max(sizes, key=lambda id: sizes[id])
    alone = only(held, [part for part in held.parts if part.id == strongest])
    weaker = ", ".join(id for id in sizes if id != strongest)
    if _size(alone, strongest) < SURE:
        alone, weaker = joint(held.bench, []), suspects
    if weaker:
        notes.append(f"{weaker} would fit, but may be noise: no trajectory was run twice")
    return alone


def _size(held: Joint, id: str) -> float:
    """How much more is left on the axes of an effect without it: ratio of mean squares."""
    mine = [part for part in held.parts if part.id == id]
    rest = only(held, [part for part in held.parts if part.id != id])
    axes = sorted({part.axis for part in mine if part.axis is not None})
    places = axes if all(part.axis is not None for part in mine) else list(range(held.bench.n))
    blocks = held.bench.made.blocks
    plain, left = (axis_rms(blocks, v)[places] ** 2 for v in (rest.residual, held.residual))
    return float(plain.sum() / max(left.sum(), 1e-300))


def sentence(axes: Sequence[int]) -> str:
    """What is said of such axes."""
    listed = ", ".join(str(i + 1) for i in axes)
    return (
        f"more than {POOR:.0%} of the torque of axis {listed} stays unexplained by all that"
        " was found: nothing is named there"
    )
