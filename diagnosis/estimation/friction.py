"""What every drive has beside the base model: friction, and an offset of the reported torque.

    F_c[i] s + d[i] thetad + o[i]

The dry friction s turns over with the rate, tanh(thetad / v_s); with the way since the last
reversal, as Dahl has it; or a time T before the rate does, tanh((thetad + T thetadd) / v_s), as the
soft constraints of simulators do. What is left of an axis' torque says which, and how sharply: a
wrong form looks like a delay of the torques, and like damping.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Known
from flexhex.diagnosis.estimation.motion import dahl_states
from flexhex.diagnosis.estimation.structure import Span
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.design import beside_of
from flexhex.diagnosis.regression.fitted import FixedEffect
from flexhex.diagnosis.regression.window import curvature
from flexhex.diagnosis.runs.blocks import Block
from flexhex.fmus.common.effects import library
from flexhex.numeric.convolved import convolved

Array = NDArray[np.float64]
RATES = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Rates v_s at which friction turns over, relative to the axis' RMS rate."""
WAYS = (0.001, 0.004, 0.016, 0.06)
"""Ways s_0 within which it does, relative to the axis' RMS way from its mean."""
QUIET, TAPS = 0.3, 20
"""Share of a form's rate that noise of the rate may be; lengths of the smoothing that are tried."""
LEADS, LEADING = (0.005, 0.01, 0.02), (0.01, 0.03, 0.1)
"""Times T [s] by which it does before the rate, each with these relative rates."""
PARAMETER = {"coulomb_friction": "F_c", "viscous_friction": "d", "torque_offset": "o"}
"""Effects that every drive has, and their parameters here."""
GROUP = "friction"


@dataclass(frozen=True)
class Form:
    """How the dry friction of an axis turns over: with the `rate` or the `way`, within `size` of it
    [unit]; lead: T [s]."""

    kind: str
    size: float
    unit: str
    lead: float = 0.0

    @property
    def shape(self) -> dict[str, float]:
        """Of the library's dry friction, which leads by nothing."""
        least = {s.name: s.low for s in library()["coulomb_friction"].shapes}
        return {**least, {"rate": "v_0", "way": "s_0"}[self.kind]: self.size}

    def near(self, factor: float) -> list[Form]:
        """Forms with one number larger or smaller by a factor."""
        both = (factor, 1 / factor)
        neighbours = [replace(self, size=self.size * f) for f in both]
        return neighbours + ([replace(self, lead=self.lead * f) for f in both] if self.lead else [])


def parameters(base: Base, blocks: Sequence[Block]) -> list[Known]:
    """Friction and offset of each axis that the base model has no columns for, with weak priors:
    one standard deviation makes all of the axis' torque."""
    listed, kinds, span = list[Known](), kinds_of(base, base.n), Span.of(base, blocks)
    rates = _rms(blocks, "thetad")
    torque = np.concatenate([b.run.tau.values[b.run.tau.valid] for b in blocks])
    rms = np.maximum(np.sqrt((torque**2).mean(axis=0)), np.finfo(float).tiny)
    missing = {name for id, name in PARAMETER.items() if id not in base.holds}
    for i, kind in enumerate(kinds):
        own = (
            ("F_c", "N m", rms[i], lambda v: np.sign(v)),
            ("d", "N m s/rad", rms[i] / rates[i], lambda v: v),
            ("o", "N m", rms[i], lambda v: np.ones_like(v)),
        )
        for name, unit, size, of_rate in own:
            if name in missing and not span.holds(i, of_rate):
                full = f"{name}[{i + 1}]"
                listed.append(Known(full, kind.unit(unit), 0.0, float(size), GROUP, i))
    return listed


def forms_of(base: Base, blocks: Sequence[Block], axis: int) -> list[Form]:
    """All forms of the dry friction of an axis."""
    unit = kinds_of(base, base.n)[axis].unit("rad")
    rate, way = (float(_rms(blocks, name)[axis]) for name in ("thetad", "theta"))
    forms = [Form("rate", size * rate, f"{unit}/s") for size in RATES]
    forms += [Form("way", size * way, unit) for size in WAYS]
    return forms + [Form("rate", v * rate, f"{unit}/s", T) for T in LEADS for v in LEADING]


def dry(block: Block, axis: int, form: Form) -> Array:
    """Smoothed s (m,) of an axis in a block."""
    motion = block.run.motion
    if form.kind == "way":
        return block.smooth(dahl_states(motion.steady[:, [axis]], form.size)[:, 0])
    rate = motion.thetad[:, axis]
    if form.lead:
        rate = rate + form.lead * motion.thetadd[:, axis]
    return block.smooth(np.tanh(_quiet(rate, block, axis, form) / form.size))


def _quiet(rate: Array, block: Block, axis: int, form: Form) -> Array:
    """The rate (samples,) of a form without the noise that it has from differences of the angle,
    which would turn friction over and over: smoothed until little of the form's size is left of
    that, over the window of the fit at most."""
    motion, longest = block.run.motion, int(np.diff(block.weights.indptr).max())
    if motion.noise is None or not motion.derived:
        return rate
    for taps in np.unique(np.geomspace(1, longest, TAPS).astype(int)):
        length = float(taps) * motion.ts
        noise = np.sqrt(2 * motion.ts / length**3) * np.pi
        noise += form.lead * curvature(length, motion.ts)
        if motion.noise[axis] * noise < QUIET * form.size:
            break
    window = np.hanning(2 * (taps // 2) + 3)[1:-1]
    padded = np.pad(rate, len(window) // 2, mode="edge")
    return convolved(padded, window / window.sum())


def columns(blocks: Sequence[Block], listed: Sequence[Known], forms: Sequence[Form]) -> list[Array]:
    """Smoothed columns (m, n, k) of these parameters in each block."""
    smoothed = []
    for block in blocks:
        sampled = np.zeros((len(block.at), len(forms), len(listed)))
        for k, known in enumerate(listed):
            axis, name = known.axis or 0, known.name.partition("[")[0]
            if name == "F_c":
                sampled[:, axis, k] = dry(block, axis, forms[axis])
            elif name == "d":
                sampled[:, axis, k] = block.smooth(block.run.motion.thetad[:, axis])
            else:
                sampled[:, axis, k] = 1.0
        smoothed.append(sampled)
    return smoothed


def effects(
    listed: Sequence[Known], values: Sequence[float], forms: Sequence[Form]
) -> list[FixedEffect]:
    """The library's effects of these parameters and values of a fit."""
    ids = {name: id for id, name in PARAMETER.items()}
    known = {c.effect.id: c for c in compiled(len(forms), {id: library()[id] for id in PARAMETER})}
    fixed = list[FixedEffect]()
    for own, value in zip(listed, values, strict=True):
        axis, id = own.axis or 0, ids[own.name.partition("[")[0]]
        shape = forms[axis].shape if known[id].effect.shapes else {}
        fixed.append(FixedEffect(known[id], axis, shape, np.array([value])))
    return fixed


def beside(model: Calibrated, listed: Sequence[Known], columns: Sequence[Array]) -> Calibrated:
    """A base model with further parameters after its own."""
    scale = np.array([known.tolerance for known in listed])
    B = [beside_of(b, c * scale) for b, c in zip(model.B, columns, strict=True)]
    return replace(
        model,
        known=(*model.known, *listed),
        scale=np.concatenate([model.scale, scale]),
        B=tuple(B),
    )


def _rms(blocks: Sequence[Block], name: str) -> Array:
    values = np.concatenate([getattr(block.run.motion, name) for block in blocks])
    if name == "theta":
        values = values - values.mean(axis=0)
    return np.asarray(np.maximum(np.sqrt((values**2).mean(axis=0)), np.finfo(float).tiny))
