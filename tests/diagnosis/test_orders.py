"""Orders of a wave over the angle that the search begins from."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.orders import promising_orders

STROKE, WINDOW = 10.0, 0.02


def swept(share: float, order: float) -> Any:
    """Rows of one axis that has a wave of an order [1/rad], and a base model that explains nothing;
    this share of them is slow [0.5 rad/s], the others are fast [20 rad/s]."""
    angle = np.linspace(0.0, STROKE, 8000)
    rate = np.where(np.arange(len(angle)) < share * len(angle), 0.5, 20.0)
    motion = SimpleNamespace(theta=angle[:, None], thetad=rate[:, None])
    block = SimpleNamespace(smooth=lambda x: x, run=SimpleNamespace(motion=motion))
    regression = SimpleNamespace(q=np.zeros(1))
    made = SimpleNamespace(
        base=SimpleNamespace(window=WINDOW), blocks=[block], regression=regression
    )
    still = np.zeros((len(angle), 1))
    return SimpleNamespace(made=made, raw=np.concatenate, y=[np.cos(order * angle)], B=[still])


@pytest.mark.parametrize(
    ("share", "shown"), [(1.0, True), (0.15, True), (0.0, False)], ids=["slow", "some", "fast"]
)
def test_wave_is_tried_where_slow_rows_show_it(share: float, shown: bool) -> None:
    """At 20 rad/s the window averages 6 of its periods."""
    orders, _ = promising_orders(swept(share, 100.0), 0)
    nearest = min(abs(order - 100.0) for order in orders)
    # half the spacing of points, which are four in what the stroke tells apart
    assert (nearest <= np.pi / STROKE / 4) == shown
