"""Rows of the fault table are compared as far as processors agree, and no farther."""

from __future__ import annotations

import pytest

from tests.gateway.fault_table import Fall, Row, alike

FALL = Fall("an axis jams", "feedback_torque", "land", 1303, 0.71, 0.42, "fault: 2", (2,))


@pytest.mark.parametrize(
    ("change", "same"),
    [
        ({"cycles": 1302}, True),
        ({"cycles": 1305}, False),
        ({"cycles": None}, False),
        ({"speed": 0.73}, True),
        ({"speed": 0.74}, False),
        ({"drives": "fault: 3"}, False),
        ({"unknown": (3,)}, False),
        ({"unknown": ()}, False),
        ({"rule": "speed"}, False),
    ],
)
def test_rows_that_differ_are_seen(change: dict[str, object], same: bool) -> None:
    other = Fall(**(FALL.__dict__ | change))
    assert alike(str(FALL), str(other)) is same


def test_short_times_are_exact() -> None:
    one, other = (Row("cable cut", "lost_frames", "zero", cycles, 2.0) for cycles in (7, 8))
    assert alike(str(one), str(one))
    assert not alike(str(one), str(other))
