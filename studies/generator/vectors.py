"""Vectors, rotations and quaternions of many samples at once: components first, samples last."""

from __future__ import annotations

import numpy as np

from tests.oracles.calculus import Array


def cross(a: Array, b: Array) -> Array:
    """Cross product of (3, ...) arrays."""
    x, y, z = a
    u, v, w = b
    return np.stack(np.broadcast_arrays(y * w - z * v, z * u - x * w, x * v - y * u))


def dot(a: Array, b: Array) -> Array:
    """Scalar product of (3, ...) arrays."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def times(R: Array, v: Array) -> Array:
    """R v for R (n, m, ...) and v (m, ...)."""
    return np.asarray(sum(R[:, k] * v[k] for k in range(R.shape[1])))


def back(R: Array, v: Array) -> Array:
    """R^T v."""
    return times(np.swapaxes(R, 0, 1), v)


def rotation(lam: Array) -> Array:
    """Rotation matrix (3, 3, ...) of unit quaternions (4, ...)."""
    w, x, y, z = lam
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows)


def multiplied(a: Array, b: Array) -> Array:
    """Quaternion product of (4, ...) arrays."""
    return np.concatenate(
        [(a[0] * b[0] - dot(a[1:], b[1:]))[None], a[0] * b[1:] + b[0] * a[1:] + cross(a[1:], b[1:])]
    )


def minimal(n: Array) -> Array:
    """Smallest rotation (3, 3, ...) that takes the x axis to n (3, ...)."""
    x, y, z = n
    c = 1 / (1 + x)
    return np.array([[x, -y, -z], [y, 1 - y * y * c, -y * z * c], [z, -y * z * c, 1 - z * z * c]])


def matmul(P: Array, Q: Array) -> Array:
    return np.stack([times(P, Q[:, k]) for k in range(3)], axis=1)


def transposed_matmul(P: Array, Q: Array) -> Array:
    return np.stack([back(P, Q[:, k]) for k in range(3)], axis=1)
