"""How much less sure of its parameters a model is than noise alone would make it.

What a model lacks repeats, goes on for longer than noise, and is larger. Every row then says the
same again: least squares follow it with parameters that hardly matter otherwise, and leave what is
known of them. How far they do, the residual shows: the variance of what it makes of a parameter's
column, second by second (White 1980, with clusters), relative to that which white noise would make.
What is known of a parameter counts so many times.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.regression.design import Design

Array = NDArray[np.float64]


def doubt(design: Design, residual: Sequence[Array], cluster: NDArray[np.int64]) -> Array:
    """Of each column (width,), 1 or more: whitened residuals (R,) of each axis, and the cluster of
    each row (R,)."""
    rows = np.arange(len(cluster))
    scores, squares = np.zeros((int(cluster.max()) + 1, design.width)), np.zeros(design.width)
    for pieces, left in zip(design.pieces, residual, strict=True):
        by_cluster = csr_array((left, (cluster, rows)), shape=(len(scores), len(rows)))
        for places, columns in pieces:
            scores[:, places] += by_cluster @ columns
            squares[places] += np.einsum("ij,ij->j", columns, columns)
    varied = (scores**2).sum(axis=0)
    ratio = np.divide(varied, squares, where=squares > 0, out=np.ones(design.width))
    return np.asarray(np.maximum(ratio, 1.0))
