"""What has no name: smooth functions of one thing that an axis does, or of all of them together.

    tau = f(angle), f(angle) direction, f(rate), f(acceleration), f(torque), f(all of them)

f is a Gaussian process of unknown length and size, so its evidence is one of closed form; and a
linear response with memory to rate and acceleration. This is the ceiling of what can be explained
without knowing what it is. Time in a run is no argument: offsets wander with it, and what repeats
of it is seen without a form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from flexhex.diagnosis.selection.rows import Rows
from flexhex.numeric.scan import ScanFunction, scans

Array = NDArray[np.float64]
PLACES, LENGTHS = 40, (0.3, 0.1, 0.03)
FINE, NARROW = 80, (*LENGTHS, 0.012)
"""Places along the range of an argument, and lengths over which a function of it goes together,
relative to the range; the same of the angle, over which a function may be narrow."""
WAVES, LENGTH = 100, 1.5
"""Waves over all arguments together, and their length in standard deviations."""
CREEP = 0.1
"""Rate, relative to its RMS, within which the direction turns."""
TIMES, LONGEST = 8, 2.0
"""Time constants of the linear response, and the longest [s]; the shortest is half a window."""


@dataclass(frozen=True, eq=False)
class Generic:
    """Columns raw, white (R, k) of an axis, of unit RMS torque for coefficients of one; ways: how
    the coefficients go together, each (k, k'): one evidence each; place: where its columns stand
    among those of all together."""

    argument: str
    raw: Array
    white: Array
    ways: tuple[Array, ...]
    place: slice


def generic(rows: Rows, axis: int) -> list[Generic]:
    """All that an axis may have without a name, the last one all of it together."""
    arguments = _arguments(rows, axis)
    unit = float(rows.torque_rms[axis])
    smooth, one = tuple(_together(length) for length in LENGTHS), (np.eye(WAVES),)
    narrow = tuple(_together(length, FINE) for length in NARROW)
    listed: list[tuple[str, list[Array], tuple[Array, ...]]] = []
    listed.append(("angle", _along(rows, axis, FINE), narrow))
    for name, values in arguments.items():
        if name not in ("direction", "angle"):
            listed.append((name, _hats(values), smooth))
    pairs = zip(_along(rows, axis, PLACES), arguments["direction"], strict=True)
    listed.append(("angle and direction", [h * d[:, None] for h, d in pairs], smooth))
    listed.append(("present motion", _waves(list(arguments.values())), one))
    memory = _memory(rows, axis)
    listed.append(("past motion", memory, (np.eye(memory[0].shape[1]),)))
    whole = [unit * np.hstack(own) for own in zip(*(v for _, v, _ in listed), strict=True)]
    raw, white = rows.raw(whole), rows.white(axis, whole)
    ends = np.cumsum([0, *(values[0].shape[1] for _, values, _ in listed)]).tolist()
    middle = block_diag(*(ways[len(ways) // 2] for _, _, ways in listed))
    kinds = [
        (name, ways, slice(*of)) for (name, _, ways), of in zip(listed, pairwise(ends), strict=True)
    ]
    kinds.append(("present and past motion", (middle,), slice(0, ends[-1])))
    return [Generic(name, raw[:, p], white[:, p], ways, p) for name, ways, p in kinds]


def hats(rows: Rows, axis: int, names: Sequence[str], places: int) -> list[Array]:
    """Hat functions (R, places) of each of some arguments of an axis."""
    arguments = _arguments(rows, axis)
    return [rows.raw(_hats(arguments[name], places)) for name in names]


def _arguments(rows: Rows, axis: int) -> Mapping[str, list[Array]]:
    """What f may depend on, at the rows (m,) of each block, of unit RMS over all blocks."""
    model = rows.model
    arguments = dict[str, list[Array]]()
    for name in ("theta", "thetad", "thetadd"):
        arguments[name] = [b.smooth(getattr(b.run.motion, name)[:, axis]) for b in model.blocks]
    arguments["torque"] = [
        b.smooth(r[:, axis]) for b, r in zip(model.blocks, model.raw, strict=True)
    ]
    unit = {name: _normal(values) for name, values in arguments.items()}
    size = float(np.concatenate(arguments["thetad"]).std()) or 1.0
    direction = [np.tanh(rate / (CREEP * size)) for rate in arguments["thetad"]]
    names = {"theta": "angle", "thetad": "rate", "thetadd": "acceleration"}
    return {**{names.get(k, k): v for k, v in unit.items()}, "direction": direction}


def _normal(values: Sequence[Array]) -> list[Array]:
    whole = np.concatenate(values)
    centre, size = float(whole.mean()), float(whole.std()) or 1.0
    return [(v - centre) / size for v in values]


def _along(rows: Rows, axis: int, places: int) -> list[Array]:
    """Hat functions (m, places) of the angle under the window: it may pass one within a window."""
    blocks = rows.model.blocks
    ends = [(v.min(), v.max()) for v in (b.few(b.run.motion.theta[:, axis]) for b in blocks)]
    low, high = min(v for v, _ in ends), max(v for _, v in ends)
    # what changes from place to place is a wave of two of them
    order = np.pi * (places - 1) / (high - low) if high > low else 0.0
    halvings = max(block.halvings(axis, order) for block in blocks)
    placed = []
    for block in blocks:
        few = block.fewer(halvings)
        angle = np.clip(few(block.run.motion.theta[:, axis]), low, high)
        at = (angle - low) / max(high - low, np.finfo(float).tiny) * (places - 1)
        first = np.clip(np.floor(at).astype(int), 0, places - 2)
        count, share = np.arange(len(at)), at - first
        pairs = np.concatenate([1 - share, share]), (np.tile(count, 2), np.r_[first, first + 1])
        hats = csr_array(pairs, shape=(len(at), places))
        placed.append((few.weights @ hats).toarray())
    return placed


def _hats(values: Sequence[Array], places: int = PLACES) -> list[Array]:
    """Hat functions (m, places) of an argument, each on its part of the range."""
    low, high = min(v.min() for v in values), max(v.max() for v in values)
    at = [(v - low) / max(high - low, np.finfo(float).tiny) * (places - 1) for v in values]
    return [np.maximum(0.0, 1.0 - np.abs(p[:, None] - np.arange(places))) for p in at]


def _together(length: float, places: int = PLACES) -> Array:
    """How the places (places, k) of a function go together that is smooth over this length."""
    at = np.arange(places) / (places - 1)
    values, vectors = np.linalg.eigh(np.exp(-(((at[:, None] - at) / length) ** 2) / 2))
    kept = values > 1e-6 * values[-1]
    return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))


def _waves(arguments: Sequence[Sequence[Array]]) -> list[Array]:
    """Waves (m, WAVES) over all arguments: a smooth function of several of them at once."""
    rng = np.random.default_rng(0)
    mixed = rng.normal(size=(len(arguments), WAVES)) / LENGTH
    # each wave goes with about half of the arguments
    mixed *= rng.random(mixed.shape) < 0.5
    phase = rng.uniform(0, 2 * np.pi, WAVES)
    together = [np.stack(own, axis=1) for own in zip(*arguments, strict=True)]
    return [np.sqrt(2.0 / WAVES) * np.cos(own @ mixed + phase) for own in together]


@cache
def _lags() -> ScanFunction:
    """First-order lags (samples, 2 TIMES) of two signals (samples, 2), each by what a step of time
    keeps (TIMES,)."""
    before, x, kept = (ca.SX.sym(*of) for of in (("before", 2), ("x", 2), ("kept", TIMES)))
    state = ca.SX.sym("state", 2 * TIMES)
    twice = ca.vertcat(kept, kept)
    now = ca.vertcat(*(ca.repmat(x[k], TIMES) for k in range(2)))
    then = twice * state + (1 - twice) * now
    return scans([ca.Function("scan_lags", [state, before, x, kept], [then])])[0]


def remembered(seen: Array, ts: float, window: float) -> Array:
    """Two signals (samples, 2) as first-order lags remember them (samples, 2 TIMES), which had long
    been what they are first."""
    kept = np.exp(-ts / np.geomspace(window / 2, LONGEST, TIMES))
    first = np.concatenate([(1 - kept) * value for value in seen[0]])
    return np.asarray(_lags()(first, seen, kept))


def _memory(rows: Rows, axis: int) -> list[Array]:
    """Rate and acceleration (m, 2 TIMES) as first-order lags remember them."""
    model = rows.model
    listed = []
    for block in model.blocks:
        motion = block.run.motion
        seen = np.stack([motion.thetad[:, axis], motion.thetadd[:, axis]], axis=1)
        listed.append(block.smooth(remembered(seen, motion.ts, model.base.window)))
    size = np.concatenate(listed).std(axis=0)
    return [v / np.where(size > 0, size, 1.0) for v in listed]
