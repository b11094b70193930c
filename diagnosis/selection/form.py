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

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.generic import hats
from flexhex.diagnosis.selection.moments import Term
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]
ARGUMENTS, LOADED, PLACES = ("angle", "rate"), ("angle", "rate", "torque"), 5
"""What a factor is smooth in, the same of what goes with the torque; places along each range."""


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


def mean_errors(criteria: Criteria) -> dict[bool, float]:
    """What the error of a form does to a gain, relative, one standard deviation, by whether the
    form is exact: the mean of a factor over its places."""
    sizes = {True: criteria.exact_form_error, False: criteria.form_error}
    return {exact: float(size / np.sqrt(PLACES)) for exact, size in sizes.items()}


def _errors(rows: Rows, torque: Array, factors: Array) -> Array:
    """Columns (R, k) of the error of a torque (R,)."""
    late = np.concatenate([np.gradient(torque[run]) for run in rows.runs])
    size = np.sqrt((late**2).mean())
    late *= np.sqrt((torque**2).mean()) / size if size > 0 else 0.0
    return np.hstack([torque[:, None] * factors, late[:, None]])
