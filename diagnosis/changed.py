"""Is a parameter of the model another than the machine file says?

All parameters may differ from their nominal values within tolerances. A change is one that the
tolerances make improbable: freeing one direction (a parameter, a kind of flexure on all arms, a
point mass on the end-effector) must lower the penalised sum of squares by far more than chance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.base import Known
from flexhex.diagnosis.calibrate import LOOSE
from flexhex.diagnosis.payloads import GROUP
from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.verdict import Changed, Estimate

Array = NDArray[np.float64]
FALL = 14.0
"""Fall of the penalised sum of squares that a change must bring: 3.7 tolerances."""
EACH = 4.0
"""The same for every further direction that is freed together."""
BESIDE = 0.5
"""An effect that explains less than this share of its own beside a change is that change."""
MOST = 6
NO_PARAMETER = ("delay", "history", GROUP)
"""Groups of columns that are no parameters of the machine itself."""
CORRELATED = 3.0
"""Rows that count as one, for what the noise model does not know."""


@dataclass(frozen=True)
class Direction:
    """What may change together: columns of U (nb, k); names of the parameters to report."""

    name: str
    U: Array
    shown: tuple[int, ...]


def changes(
    regression: Regression, known: tuple[Known, ...], extra: Mapping[str, Array]
) -> list[Changed]:
    """Changed parameters, the most certain first.

    regression: base columns as far as `known` goes, then those of effects found. extra: more
    directions by name, in units of the parameters (len(known),).
    """
    if not any(np.isfinite(k.tolerance) for k in known):
        return []
    G, b, Lambda = normal(regression, known)
    free: list[Direction] = []
    listed = _directions(known, extra, len(b))
    for _ in range(min(MOST, len(listed))):
        scores = _scores(G, b, Lambda, free, listed)
        top = int(np.argmax(scores))
        if scores[top] < FALL:
            break
        free.append(listed.pop(top))
    return _reported(G, b, Lambda, free, known)


def best_change(
    regression: Regression, known: tuple[Known, ...], extra: Mapping[str, Array]
) -> float:
    """Fall of the penalised sum of squares that the best single change brings."""
    G, b, Lambda = normal(regression, known)
    listed = _directions(known, extra, len(b))
    return float(max(_scores(G, b, Lambda, [], listed), default=0.0))


def only_changed(
    plain: Regression, effect: Columns, known: tuple[Known, ...], extra: Mapping[str, Array]
) -> bool:
    """Whether one changed parameter explains more than an effect, and most of what the effect does.

    plain: base columns as far as `known` goes, then those of other effects.
    """
    listed = _directions(known, extra, len(plain.prior))
    if not listed:
        return False
    level = dispersion(plain)
    G, b, Lambda = normal(plain, known, level)
    change = listed[int(np.argmax(_scores(G, b, Lambda, [], listed)))]
    nothing, changed = (_cost(G, b, Lambda, free) for free in ([], [change]))
    G, b, Lambda = normal(plain.extended([effect]), known, level)
    wider = replace(change, U=np.pad(change.U, ((0, len(b) - len(change.U)), (0, 0))))
    named, both = (_cost(G, b, Lambda, free) for free in ([], [wider]))
    explained = nothing - named
    return nothing - changed > max(explained, FALL) and changed - both < BESIDE * explained


def dispersion(regression: Regression) -> float:
    """Mean square of the residual for as many rows as go together."""
    return max(1.0, float((regression.residual**2).mean())) * CORRELATED


def normal(
    regression: Regression, known: tuple[Known, ...], level: float = 0.0
) -> tuple[Array, Array, Array]:
    """Gram matrix, right side, and weights of the nominal values by their tolerances; level: the
    dispersion, where it is not to be that of the regression."""
    nb, level = len(regression.prior), level or dispersion(regression)
    G, b = np.zeros((nb, nb)), np.zeros(nb)
    for part, rhs in regression.grams:
        G, b = G + part, b + rhs
    Lambda = np.zeros(nb)
    Lambda[: len(known)] = [LOOSE**2 if np.isfinite(k.tolerance) else 0.0 for k in known]
    return G / level, b / level, Lambda


def _scores(
    G: Array, b: Array, Lambda: Array, free: list[Direction], listed: list[Direction]
) -> list[float]:
    """Fall that each direction brings beside those that are free, less for wider ones."""
    level = _cost(G, b, Lambda, free)
    falls = [level - _cost(G, b, Lambda, [*free, d]) for d in listed]
    return [f - EACH * (d.U.shape[1] - 1) for f, d in zip(falls, listed, strict=True)]


def _precision(Lambda: Array, free: list[Direction]) -> Array:
    P = np.diag(Lambda)
    if not free:
        return P
    U = np.hstack([d.U for d in free])
    LU = P @ U
    return np.asarray(P - LU @ np.linalg.pinv(U.T @ LU) @ LU.T)


def _cost(G: Array, b: Array, Lambda: Array, free: list[Direction]) -> float:
    A = G + _precision(Lambda, free)
    A = A + 1e-10 * np.diag(np.maximum(np.diag(A), 1e-300))
    return -float(b @ np.linalg.solve(A, b))


def _directions(known: tuple[Known, ...], extra: Mapping[str, Array], nb: int) -> list[Direction]:
    """Every parameter, every kind that several arms share, and what the base model adds."""
    found, n = [], len(known)
    scale = np.array([LOOSE * k.tolerance for k in known])
    for j, k in enumerate(known):
        if k.group in NO_PARAMETER or not 0 < k.tolerance < np.inf:
            continue
        U = np.zeros((nb, 1))
        U[j] = 1.0
        found.append(Direction(k.name, U, (j,)))
    groups: dict[str, list[int]] = {}
    for j, k in enumerate(known):
        if k.group not in NO_PARAMETER:
            groups.setdefault(k.group, []).append(j)
    for name, members in groups.items():
        if len(members) > 1:
            U = np.zeros((nb, 1))
            U[members] = 1.0 / np.sqrt(len(members))
            found.append(Direction(name, U, (members[0],)))
    for name, vector in extra.items():
        U = np.zeros((nb, 1))
        vector = np.pad(vector, (0, n - len(vector)))
        U[:n, 0] = np.where(np.isfinite(scale) & (scale > 0), vector / scale, 0.0)
        largest = [j for j in range(n) if known[j].name == name]
        U /= np.linalg.norm(U)
        found.append(Direction(name, U, tuple(largest)))
    return found


def _reported(
    G: Array, b: Array, Lambda: Array, free: list[Direction], known: tuple[Known, ...]
) -> list[Changed]:
    if not free:
        return []
    A = G + _precision(Lambda, free)
    A = A + 1e-10 * np.diag(np.maximum(np.diag(A), 1e-300))
    q, covariance = np.linalg.solve(A, b), np.linalg.inv(A)
    made, seen = [], set()
    for d in free:
        for j in d.shown:
            k = known[j]
            scale = LOOSE * k.tolerance
            value = k.nominal + scale * q[j]
            reach = 1.96 * scale * float(np.sqrt(max(covariance[j, j], 0.0)))
            name = d.name if len(d.shown) == 1 else k.name
            if name in seen:
                continue
            seen.add(name)
            ci = (float(value - reach), float(value + reach))
            made.append(Changed(name, k.nominal, Estimate(float(value), ci, k.unit)))
    return made
