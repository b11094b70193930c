"""Nature is not the library's form: errors of the form of an accepted effect, as columns.

The torque t of an effect, as it was fitted, may be wrong by a factor that is smooth along the
stroke and in the rate, if it goes with the torque in that as well; and it may come a little early
or late:

    error = t (e_1(angle) + e_2(rate) [+ e_3(torque)]) + e_4 dt/dt

Each of the e is about zero, with the effect's form error as standard deviation. What lies within it
is no evidence for another effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from flexhex.diagnosis.selection.generic import hats, remembered
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]
ARGUMENTS, LOADED, PLACES = ("angle", "rate"), ("angle", "rate", "torque"), 5
"""What a factor is smooth in, the same of what goes with the torque; places along each range."""
MANY = 40
"""Places of a factor that need not be smooth. Halved or doubled it leaves the names of four axes as
they are, with friction and a wave and its harmonic, a bump, or Stribeck friction (twice)."""
ALIKE = 1e-10
"""Square of what a column of size one has to add to the others to say something of its own."""
STEPS = 20
"""Times that errors of form that are too large are made smaller, at most."""


def form_errors(
    rows: Rows, term: Term, gains: Array, relative: float, arguments: Sequence[str] = ARGUMENTS
) -> Term:
    """Columns of the error, of so much relative, of the form of a term whose gains are about these
    (k,)."""
    raw, white = dict[int, Array](), dict[int, Array]()
    for i in term.white:
        factors = np.hstack(hats(rows, i, arguments, PLACES))
        raw[i], white[i] = (
            _errors(rows, own @ gains, factors) for own in (term.raw[i], term.white[i])
        )
    width = len(arguments) * PLACES
    return Term(raw, white, np.r_[np.full(width, len(arguments)), 1.0] / relative**2)


def inexact(moments: Moments, error: Term) -> float:
    """How large the factors of an error of form are, relative to the size that it was given, and at
    most as large: more than that is a rest beside the effect, and is reported as one.

    The mean square of the coefficients that the data determine (MacKay's effective number), and one
    more that is as large as was thought: where they determine none the answer is 1.
    """
    fit, place = moments.fit(None), moments.place(error)
    factors = np.arange(place.start, place.stop - 1)  # the last column is a shift in time
    squares = error.prior[:-1] * fit.q[factors] ** 2
    variances = np.diag(fit.solve(np.eye(moments.m)[:, factors])[factors])
    determined = np.clip(1.0 - moments.prior[factors] * variances, 0.0, 1.0)
    mean = (1.0 + squares.sum()) / (1.0 + determined.sum())
    return float(np.sqrt(min(mean, 1.0)))


def limited(moments: Moments, pairs: Sequence[tuple[Term, Term]], most: float) -> Moments:
    """The model in which errors of form are no larger than they may be: terms of effects and of
    the errors of their form; most: how large these may be relative to the effect (RMS).

    What many rows ask for outweighs a standard deviation that was thought before: friction without
    what grows with the rate would be bent until it has that, too.
    """
    tight = dict.fromkeys((error for _, error in pairs), 1.0)
    model = moments.tightened(tight)
    for _ in range(STEPS):
        sizes = {error: _size(model, term, error) / most for term, error in pairs}
        if max(sizes.values(), default=0.0) <= 1.0:
            break
        tight |= {e: tight[e] * (1.0 + size) for e, size in sizes.items() if size > 1.0}
        model = moments.tightened(tight)
    return model


def _size(moments: Moments, term: Term, error: Term) -> float:
    """How large the error of form of an effect is beside it, RMS; the shift in time is none."""
    whole, wrong = np.zeros((2, moments.m))
    own, factors = moments.place(term), moments.place(error)
    factors = slice(factors.start, factors.stop - 1)
    whole[own], wrong[factors] = (moments.fit(None).q[place] for place in (own, factors))
    torque = float(np.linalg.norm(moments.sizes(whole)))
    return float(np.linalg.norm(moments.sizes(wrong))) / torque if torque > 0 else 0.0


@dataclass(frozen=True)
class Space:
    """All combinations of columns (R, k); sizes (k,) of these, factor (k, k): the lower Cholesky
    factor of their products, each of size one."""

    columns: Array
    sizes: Array
    factor: Array

    @staticmethod
    def of(columns: Array) -> Space:
        """Of columns (R, k), by their products: singular values take ten times as long."""
        products = columns.T @ columns
        sizes = np.sqrt(np.diag(products))
        there = sizes > 0
        sizes = sizes[there]
        products = products[np.ix_(there, there)] / np.outer(sizes, sizes)
        factor = cholesky(products + ALIKE * np.eye(len(sizes)), lower=True)
        return Space(columns[:, there], sizes, factor)

    def square(self, values: Array) -> float:
        """Of the square of values (R,), the part in this space; less of it in directions in which
        the columns hardly say anything of their own."""
        along = (self.columns.T @ values) / self.sizes
        part = solve_triangular(self.factor, along, lower=True)
        return float(part @ part)


def space_of_errors(rows: Rows, axis: int, torque: Array, others: Sequence[Array] = ()) -> Space:
    """All errors of the form of a torque (R,) of an axis, smooth or not, what it leaves behind for
    a while, and `others` that it may be a part of."""
    errors = _errors(rows, torque, np.hstack(hats(rows, axis, LOADED, MANY)))
    seen = np.stack([torque, errors[:, -1]], axis=1)
    ts, window = rows.model.spacing, rows.model.base.window
    late = np.concatenate([remembered(seen[run], ts, window) for run in rows.runs])
    return Space.of(np.column_stack([errors, late, *others]))


def mean_error(relative: float) -> float:
    """What an error of form, relative, does to a gain: the mean of a factor over its places, one
    standard deviation."""
    return float(relative / np.sqrt(PLACES))


def _errors(rows: Rows, torque: Array, factors: Array) -> Array:
    """Columns (R, k) of the error of a torque (R,)."""
    late = np.concatenate([np.gradient(torque[run]) for run in rows.runs])
    size = np.sqrt((late**2).mean())
    late *= np.sqrt((torque**2).mean()) / size if size > 0 else 0.0
    return np.hstack([torque[:, None] * factors, late[:, None]])
