"""What base parameters that leave their tolerances add to the log density of left-out folds."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.changed import ChangedParameter
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import log_evidence, turned_to
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.scores import Score

Array = NDArray[np.float64]


def change_scores(
    moments: Moments, changes: Iterable[ChangedParameter], criteria: Criteria
) -> list[Score]:
    """Parameters that may leave their tolerances, on left-out folds; not those whose values no
    machine can have. What gains nothing has no size."""
    alike = dict[int, list[ChangedParameter]]()
    for change in changes:
        alike.setdefault(change.ways.shape[1], []).append(change)
    lefts, scores = [None, *moments.rows.folds], list[Score]()
    alone = {left: _parameters_alone(moments, left) for left in lefts}
    for listed in alike.values():
        priors = np.array([[change.deviation(criteria) ** -2.0] for change in listed])
        often = np.array([[moments.rows.often(change.places)] for change in listed])
        total, gains = dict[Left, Array](), np.zeros(0)
        for left, (S, r) in alone.items():
            own = [(S[np.ix_(c.places, c.places)], r[list(c.places)], c.ways) for c in listed]
            squares = np.array([W.T @ of @ W for of, _, W in own])
            right = np.array([W.T @ b for _, b, W in own])
            values, turned, vectors = turned_to(squares, right)
            if left is None:
                gains = (vectors @ (turned / (values + often * priors))[:, :, None])[:, :, 0]
            total[left] = log_evidence(values / often, turned / often, priors)
        for k, change in enumerate(listed):
            if change.possible(gains[k]):
                without = np.array([total[fold][k] for fold in moments.rows.folds])
                whole = float(total[None][k])
                size = _size_of(moments, change, gains[k]) if whole > 0 else 0.0
                scores.append(Score(change, whole, without, size))
    return scores


def _parameters_alone(moments: Moments, left: Left) -> tuple[Array, Array]:
    """Products (nb, nb) of the base model's columns, and (nb,) of these with the torque, less what
    the model takes up of both."""
    (G, b), fit, nb = moments.gram(left), moments.fit(left), moments.rows.nb
    half = fit.half(G[:, :nb])
    return G[:nb, :nb] - half.T @ half, b[:nb] - G[:nb] @ fit.q


def _size_of(moments: Moments, change: ChangedParameter, gains: Array) -> float:
    """Relative RMS of what parameters add, on the axis that feels them most."""
    step = np.zeros(moments.m)
    step[list(change.places)] = change.ways @ gains
    return float((moments.sizes(step) / moments.rows.torque_rms).max())
