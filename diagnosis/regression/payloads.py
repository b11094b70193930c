"""What runs carried: payloads as columns of the base model.

    tau = B(motion) (p + on(run) delta),  delta zero but for what a payload changes

A payload that the logs announce has its nominal value in `Base.loaded` and delta about that; one
that only the runs show has all of it in delta. Neither looks like an effect.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import POWER, Base, Known
from flexhex.diagnosis.runs.blocks import Block, torque_rms
from flexhex.diagnosis.runs.run import Run, announced

Array = NDArray[np.float64]
GROUP, UNSEEN = "payload", "payload"
"""Group of the parameters of all payloads; how those are named that no log announces."""
MASS = 0.05
"""One standard deviation of an announced mass, relative."""


@dataclass(frozen=True)
class Load:
    """A payload: its name; bit in `Run.loads`, None where the log announces it as `mass`; the
    parameters that it adds to those of the base model at `Base.payload`."""

    name: str
    bit: int | None
    mass: str
    known: tuple[Known, ...]

    def on(self, run: Run) -> bool:
        """Whether a run carries it."""
        if self.bit is None:
            return announced(run.payload) == self.mass
        return bool(run.loads >> self.bit & 1)


def loads_of(base: Base, blocks: Sequence[Block]) -> tuple[Load, ...]:
    """Payloads of these runs, announced ones first."""
    if not base.payload:
        return ()
    masses = dict.fromkeys(block.run.payload for block in blocks if block.run.payload)
    loads = {announced(m): Load(f"payload {m:.3g} kg", None, announced(m), ()) for m in masses}
    bits = max(block.run.loads for block in blocks).bit_length()
    names = [UNSEEN, *(f"{UNSEEN} {k}" for k in range(2, bits + 1))]
    listed = [*loads.values(), *(Load(names[k], k, "", ()) for k in range(bits))]
    return tuple(replace(load, known=_known(base, load, blocks)) for load in listed)


def columns_of(base: Base, loads: Sequence[Load], block: Block) -> list[Array]:
    """Columns (m, n, len(base.payload)) of each payload in the rows of a block."""
    own = block.linear.at(base.payload)
    return [own if load.on(block.run) else np.zeros_like(own) for load in loads]


def carried(
    base: Base, loads: Sequence[Load], added: Mapping[str, Array], run: Run, p: Array
) -> Array:
    """The linear parameters (n_p,) of a run with all that it carries; added: what payloads add to
    them, by their name."""
    parameters = base.loaded(p, run.payload).copy()
    for load in loads:
        if load.on(run):
            parameters[list(base.payload)] += added.get(load.name, 0.0)
    return parameters


def _known(base: Base, load: Load, blocks: Sequence[Block]) -> tuple[Known, ...]:
    """Its parameters. Tolerances: of an announced mass, at a place within `Base.reach`; where that
    is not known as much as makes the torque that the axes feel."""
    places, mass = list(base.payload), float(load.mass or np.inf)
    own = [block for block in blocks if load.on(block.run)]
    squares = np.mean([(b.linear.at(places) ** 2).mean(axis=0) for b in own], axis=0)
    share = (squares / torque_rms(blocks)[:, None] ** 2).mean(axis=0)
    wide = np.where(share > 0, 1 / np.sqrt(np.maximum(share, 1e-300)), 0.0)
    parameters = []
    for place, most in zip(places, wide, strict=True):
        known = base.linear[place]
        near = np.isfinite(mass * base.reach)
        tolerance = mass * _spread(base.reach, known.unit) if near else float(most)
        name = f"{load.name}.{known.name.rpartition('.')[2]}"
        parameters.append(
            Known(name, known.unit, 0.0, tolerance, GROUP, known.axis, shown=known.shown)
        )
    return tuple(parameters)


def _spread(reach: float, unit: str) -> float:
    """Tolerance of an inertial parameter for a kilogram."""
    return MASS if POWER[unit] == 0 else reach ** POWER[unit]
