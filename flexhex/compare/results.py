"""`flexhex compare`: two results signal by signal, at equal rates only, against tolerances.

Rates are never merged: a signal that the runs logged at different rates is reported, not
resampled. Two runs are equal when every signal is in both and stays within its tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.interface import array_of
from flexhex.ssp.results import Group, Result, rate_name
from flexhex.ssp.wiring import unknown
from flexhex.tracking import columns

Array = NDArray[np.float64]
RTOL = 1e-9
"""Tolerance when none is given: round-off of another compiler, nothing that acts."""
EQUAL, OUT = "equal", "out"
ONLY_FIRST, ONLY_SECOND = "only in the first", "only in the second"
UNLIKE = "not compared"
INTERNAL = frozenset({"p", "p_std", "innovation", "residual", "z", "chi_f"})
"""Outputs that are states of the estimator and the solvers, listed after motion and torque."""


@dataclass(frozen=True)
class Tolerance:
    """Largest difference allowed: atol + rtol * the column's largest value in either run.

    A signal named in `signals` has that absolute tolerance alone, in its own unit.
    """

    atol: float = 0.0
    rtol: float = RTOL
    signals: Mapping[str, float] = field(default_factory=dict)

    def limit(self, signal: str, a: Array, b: Array) -> Array:
        """Tolerance of every column (n,) of samples a, b (samples, n)."""
        if signal in self.signals:
            return np.full(a.shape[1], self.signals[signal])
        return self.atol + self.rtol * np.maximum(_peak(a), _peak(b))


@dataclass(frozen=True)
class Difference:
    """One signal in both runs. state: `equal`, `out`, `only in the first`, `only in the
    second`, `not compared`; note says why, or what else is to be said.

    element: the one that is farthest out, from 1, 0 for a scalar, and column, its name; of it are
    worst and rms, the largest and RMS difference, at [s], when it was largest, and limit, its
    tolerance. first
    [s]: when any element was out of tolerance first, NaN when none was. size: worst over the
    element's largest value; over: worst over the tolerance.
    """

    signal: str
    state: str
    rate: str = ""
    unit: str = ""
    note: str = ""
    worst: float = math.nan
    rms: float = math.nan
    element: int = 0
    column: str = ""
    at: float = math.nan
    limit: float = math.nan
    first: float = math.nan
    size: float = 0.0
    over: float = 0.0


@dataclass(frozen=True)
class Comparison:
    """All signals, worst first; provenance: what made the runs different, (first, second) by key.

    common: signals of one run alone and a longer run do not count.
    """

    differences: tuple[Difference, ...]
    provenance: Mapping[str, tuple[str, str]]
    durations: tuple[float, float]
    common: bool = False

    @property
    def equal(self) -> bool:
        """Whether the runs are equal within tolerance, as far as they were asked to be."""
        states = {d.state for d in self.differences}
        lasting = math.isclose(*self.durations, rel_tol=1e-12)
        if self.common:
            return EQUAL in states and states <= {EQUAL, ONLY_FIRST, ONLY_SECOND}
        return states == {EQUAL} and lasting

    def of(self, *states: str) -> list[Difference]:
        """The signals in one of these states."""
        return [d for d in self.differences if d.state in states]


def compare(
    first: Result, second: Result, tolerance: Tolerance | None = None, common: bool = False
) -> Comparison:
    """Compare two results. UsageError for a tolerance that is none or names no signal."""
    tolerance = tolerance or Tolerance()
    a, b = _by_signal(first), _by_signal(second)
    _check(tolerance, {**a, **b})
    either = {**a, **b}
    differences = [
        _compared(name, g, a.get(name), b.get(name), tolerance) for name, g in either.items()
    ]
    order = [OUT, UNLIKE, ONLY_FIRST, ONLY_SECOND, EQUAL]
    differences.sort(
        key=lambda d: (order.index(d.state), internal(d.signal), -d.over, -d.size, d.signal)
    )
    durations = first.duration, second.duration
    return Comparison(tuple(differences), differing_provenance(first, second), durations, common)


def tolerances(texts: Iterable[str]) -> dict[str, float]:
    """`plant.theta=1e-6` as signal and tolerance; UsageError for anything else."""
    limits = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            limits[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if not (equals and name.strip()):
            raise UsageError(f"--tol {text!r}: write SIGNAL=NUMBER, as in plant.theta=1e-6")
    return limits


def differing_provenance(first: Result, second: Result) -> dict[str, tuple[str, str]]:
    """What is not the same in the making: versions, hashes, parameters, duration; "-": absent."""
    a: dict[str, object] = {**first.meta, "duration": first.duration}
    b: dict[str, object] = {**second.meta, "duration": second.duration}
    keys = sorted({*a, *b})
    pairs = {key: (str(a.get(key, "-")), str(b.get(key, "-"))) for key in keys}
    return {key: pair for key, pair in pairs.items() if pair[0] != pair[1]}


def internal(signal: str) -> bool:
    """Whether `K.p_std` or an element of it is a state of an estimator or a solver."""
    return array_of(signal.partition(".")[2]) in INTERNAL


def _by_signal(result: Result) -> dict[str, Group]:
    return {name: group for group in result.groups.values() for name in group.signals}


def _check(tolerance: Tolerance, known: Mapping[str, Group]) -> None:
    values = {"--atol": tolerance.atol, "--rtol": tolerance.rtol}
    for name, value in (values | {f"--tol {k}": v for k, v in tolerance.signals.items()}).items():
        if not (math.isfinite(value) and value >= 0):
            raise UsageError(f"{name}: {value:g}, must be a number of at least 0")
    for name in tolerance.signals:
        if name not in known:
            raise UsageError(f"--tol {name}: in neither run, {unknown('signal', name, known)}")


def _compared(
    name: str, there: Group, a: Group | None, b: Group | None, tolerance: Tolerance
) -> Difference:
    """One signal of two groups, None where a run does not have it; `there`: one that does."""
    rate, unit = rate_name(there.period, there.base), there.units.get(name, "")
    if a is None or b is None:
        return Difference(name, ONLY_SECOND if a is None else ONLY_FIRST, rate, unit)
    reason = _unlike(name, a, b)
    if reason:
        return Difference(name, UNLIKE, rate, unit, reason)
    return _judged(name, a, b, tolerance)


def _unlike(name: str, a: Group, b: Group) -> str:
    """Why the samples cannot be compared; empty when they can."""
    pairs: Sequence[tuple[str, object, object]] = (
        ("rate", rate_name(a.period, a.base), rate_name(b.period, b.base)),
        ("unit", a.units.get(name, ""), b.units.get(name, "")),
        ("size", columns(a.signals[name]).shape[1], columns(b.signals[name]).shape[1]),
    )
    return ", ".join(f"{what} {x} and {y}" for what, x, y in pairs if x != y)


def _judged(name: str, a: Group, b: Group, tolerance: Tolerance) -> Difference:
    """Both have it at the same rate: the samples of the time that both cover."""
    rate, unit = rate_name(a.period, a.base), a.units.get(name, "")
    n = min(len(a.signals[name]), len(b.signals[name]))
    if n == 0:
        return Difference(name, UNLIKE, rate, unit, "no samples")
    x, y = columns(a.signals[name])[:n], columns(b.signals[name])[:n]
    apart, limit = distance(x, y), tolerance.limit(name, x, y)
    out = (apart > limit).any(axis=1)
    over = _ratio(apart.max(axis=0), limit) if out.any() else apart.max(axis=0)
    column = max(range(len(over)), key=lambda k: (over[k], apart[:, k].max()))
    row = int(np.argmax(apart[:, column]))
    worst = float(apart[row, column])
    peak = float(max(_peak(x[:, [column]])[0], _peak(y[:, [column]])[0]))
    return Difference(
        name,
        OUT if out.any() else EQUAL,
        rate,
        unit,
        worst=worst,
        rms=float(np.sqrt(np.mean(np.square(apart[:, column])))),
        element=column + 1 if a.signals[name].ndim > 1 else 0,
        column=a.columns(name)[column],
        at=row * a.Ts,
        limit=float(limit[column]),
        first=float(np.argmax(out) * a.Ts) if out.any() else math.nan,
        size=worst / peak if peak else worst,
        over=float(_ratio(apart[row, [column]], limit[[column]])[0]),
    )


def distance(a: Array, b: Array) -> Array:
    """|a - b|; 0 where both are the same infinity or both NaN, infinite where one is NaN."""
    with np.errstate(invalid="ignore"):
        apart = np.abs(a - b)
    apart[(a == b) | (np.isnan(a) & np.isnan(b))] = 0.0
    apart[np.isnan(apart)] = np.inf
    return np.asarray(apart)


def _ratio(apart: Array, limit: Array) -> Array:
    """How many times over the tolerance; infinite where a tolerance of 0 is exceeded."""
    with np.errstate(divide="ignore", invalid="ignore"):
        over = apart / limit
    return np.where(apart == 0, 0.0, over)


def _peak(values: Array) -> Array:
    """Largest finite magnitude of every column (n,)."""
    return np.asarray(np.max(np.abs(values), axis=0, where=np.isfinite(values), initial=0.0))
