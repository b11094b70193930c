"""Sizes of the library as they are, for made-up benches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexhex.diagnosis.hypotheses.scales import Scales
from flexhex.diagnosis.kinds import ROTARY


def usual(effects: Mapping[str, Any]) -> Scales:
    """Axes that turn, of the torque and motion that the library's sizes are for."""
    inner = {name: item.effect for name, item in effects.items()}
    return Scales(
        (ROTARY,) * 6,
        ((1.0, 1.0, 1.0),) * 6,
        places=(0.0,) * 6,
        slowest=(1.0,) * 6,
        peaks=(1.0,) * 6,
        usual=(0.1,) * 6,
        time=1.0,
        fastest=200.0,
        effects=inner,
    )
