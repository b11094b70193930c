"""How large an effect is, for a sentence."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from flexhex.diagnose.numbers import listed, measured, number, rounded
from flexhex.diagnosis.kinds import with_unit
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Named
from flexhex.fmus.common.effects import library

SEVERAL = 3
"""Axes up to which each has its own figure in a sentence."""


def sizes(effect: Named) -> str:
    """A value, one of each of a few axes, or a pair's length, with what these mean and where they
    are seen: ` of 0.05 N m with 80 periods a turn`."""
    known = library().get(effect.id)
    gains = known.gains if known else ()
    main = [g.below[0] for g in gains if g.below] or [g.name for g in gains]
    main = [known.size] if known and known.size else main
    amounts = {name: _all(effect, name) for name in main}
    amounts = {name: values for name, values in amounts.items() if values}
    text = _amounts(list(amounts.values()), len(effect.axes) < 2)
    return f"{text}{_places(effect) if text else ''}{_meaning(effect)}"


def _all(effect: Named, name: str) -> list[Estimate]:
    """Estimates of a parameter, as far as it is determined: of all axes, and of all shapes that one
    axis has it with."""
    own = {n: e for n, e in effect.parameters.items() if re.split(r"[\[#]", n)[0] == name}
    return [e for e in own.values() if e.determined]


def _amounts(estimates: Sequence[Sequence[Estimate]], alone: bool) -> str:
    if len(estimates) == 2 and alone and estimates[0][0].unit == estimates[1][0].unit:
        # sine and cosine
        lengths = [number(math.hypot(a.value, b.value)) for a, b in zip(*estimates, strict=True)]
        unit = estimates[0][0].unit
        return f" of {with_unit(listed(lengths), unit)}"
    if len(estimates) != 1:
        return ""
    (same,) = estimates
    if len(same) > SEVERAL:
        values = sorted(abs(e.value) for e in same)
        size = f"{number(values[0])} to {number(values[-1])}"
        return f" of {with_unit(size, same[0].unit)}"
    return f" of {listed([measured(e) for e in same])}"


def _places(effect: Named) -> str:
    """Where an effect of one axis is seen: of waves how many periods a turn has, or how long they
    are; of a mode its frequency."""
    if len(effect.axes) != 1:
        return ""
    orders, modes = _all(effect, "order"), _all(effect, "f")
    if orders and orders[0].unit == "1/rad":
        return f" with {listed([rounded(e, e.value) for e in orders])} periods a turn"
    if orders:
        lengths = [rounded(e, 2e3 * math.pi / e.value) for e in orders]
        return f" with periods of {listed(lengths)} mm"
    return f" at {listed([rounded(e, e.value) for e in modes])} Hz" if modes else ""


def _meaning(effect: Named) -> str:
    if effect.id not in library() or len(effect.axes) != 1:
        return ""
    values = {name: e.value for name, e in effect.parameters.items()}
    units = {name: e.unit for name, e in effect.parameters.items()}
    known = {gain.name for gain in library()[effect.id].gains} <= values.keys()
    known &= all(e.determined for e in effect.parameters.values())
    text = library()[effect.id].meaning(values, units) if known else ""
    return f" ({text})" if text else ""
