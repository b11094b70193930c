"""Columns that are kept: in any order, of several makings, until there is no room."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.selection.keep import Array, Keep

ROWS = 5
ONE = ROWS * 2 * 4
"""Memory of the two columns of a key, in half the digits [bytes]."""


def columns(*firsts: float) -> Array:
    """Two columns for each key: first and first + 0.5, the row's number beside them."""
    values = np.ravel([(first, first + 0.5) for first in firsts])
    return values + 10.0 * np.arange(ROWS)[:, None]


def test_columns_come_in_the_order_that_is_asked_for() -> None:
    keep = Keep()
    keep.add(["a", "b", "c"], {0: columns(1, 2, 3), 4: columns(-1, -2, -3)})
    keep.add(["d"], {0: columns(4), 4: columns(-4)})
    for asked, firsts in (("abc", (1, 2, 3)), ("bd", (2, 4)), ("cba", (3, 2, 1)), ("aa", (1, 1))):
        found = keep.side_by_side(list(asked))
        np.testing.assert_array_equal(found[0], columns(*firsts))
        np.testing.assert_array_equal(found[4], columns(*(-f for f in firsts)))
        assert found[0].dtype == np.float64


def test_columns_that_were_asked_for_longest_ago_make_room() -> None:
    keep = Keep(room=3 * ONE)
    keep.add(["a"], {0: columns(1)})
    keep.add(["b", "c"], {0: columns(2, 3)})
    keep.side_by_side(["a"])
    keep.add(["d"], {0: columns(4)})
    keep.side_by_side(["d"])
    assert [key in keep for key in "abcd"] == [True, False, False, True]
    assert keep.taken == 2 * ONE
