"""Gram matrices of columns of which the base model explains a part, or all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UNKNOWN = 1e-10
"""Relative curvature below which a direction is not determined."""
ABSORBED = 1e-5
"""Share of a column's square below which the base model explains all of it."""
WEAK = 0.1
"""Share of a column's square that must repeat from pass to pass: products of less are chance."""


def safe_gram(S: Array, within: Array, gone: NDArray[np.bool_]) -> Array:
    """A Gram matrix (k, k) of what is left of columns, such that those that are gone gain nothing;
    within: their squares (k,) before. One of zeros has the size of one: its inverse stays finite.
    """
    S, size = (S + S.T) / 2, np.where(within > 0, within, 1.0)
    return np.asarray(S + np.diag(np.where(gone, 1e9, 1e-9) * size))


def is_gone(S: Array, within: Array, left: Array) -> NDArray[np.bool_]:
    """Columns (k,) that the base model explains, or of which what it leaves hardly repeats.

    S (k, k): products between passes of what is left; within, left (k,): squares before and after.
    """
    least = np.maximum(ABSORBED * within, WEAK * left)
    return np.asarray(np.diag(S) <= least)


def inverted(S: Array) -> Array:
    """Pseudoinverse of a symmetric matrix whose columns have units of their own: what is small
    beside another unit is not nothing."""
    size = np.sqrt(np.maximum(np.abs(np.diag(S)), 1e-300))
    return np.asarray(np.linalg.pinv(S / np.outer(size, size)) / np.outer(size, size))


def safe_inverse(G: Array, prior: Array) -> Array:
    """Inverse of B^T B + prior (nb, nb), made safe where noise left less than the prior itself."""
    size = np.sqrt(np.maximum(np.diag(G), 1e-12))
    known = prior > 0
    least = np.where(known, 0.5 * prior / size**2, 0.0)
    values, vectors = np.linalg.eigh(G / np.outer(size, size))
    floors = (vectors**2 * least[:, None]).sum(axis=0)
    safe = np.maximum(values, floors)
    # what neither rows nor prior determine stays where it is
    inverse = np.where(safe > UNKNOWN, 1 / np.maximum(safe, UNKNOWN), 0.0)
    kept = vectors / size[:, None]
    return np.asarray((kept * inverse) @ kept.T)


def undetermined(G: Array, E: Array) -> Array:
    """Curvature (nb, nb) to add to G where noise alone moves columns, zero elsewhere.

    G, E (nb, nb): products of columns between passes and within them, E semidefinite. In the
    directions v'Gv < WEAK v'Ev the products between passes are chance, of about nothing, and a
    coefficient may be anything: with those within passes beside them it is small.
    """
    size = np.sqrt(np.maximum(np.diag(E), 1e-300))
    values, vectors = np.linalg.eigh(E / np.outer(size, size))
    there = values > UNKNOWN
    whitened = vectors[:, there] / np.sqrt(values[there]) / size[:, None]
    shares, turned = np.linalg.eigh(whitened.T @ G @ whitened)
    lost = E @ whitened @ turned[:, shares < WEAK]
    return np.asarray(lost @ lost.T)
