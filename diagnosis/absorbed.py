"""Effects that the base model can take on: with a wrong motor constant all masses of an arm look
wrong.

Beside parameters that may leave their tolerances such an effect leaves no gap. It competes with
the changed parameters instead: one number that explains what several would have to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from flexhex.diagnosis.calibrate import LOOSE
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.changed import FALL, best_change, dispersion
from flexhex.diagnosis.regression import Regression
from flexhex.diagnosis.rivals import CLOSE
from flexhex.diagnosis.rounds import LEVEL
from flexhex.diagnosis.scored import Found, Scored, allowed

GAIN, WARM = "drive_gain", "thermal_drift"
"""The effect that is asked for here, and what the same runs may not tell it from."""


def absorbed(bench: Bench, found: Sequence[Found], closed: Sequence[int]) -> Found | None:
    """Axes whose torque is all too small or too large; None where parameters explain it as well.

    found: effects known by now; closed: axes (from 0) that are not asked about. Nothing is asked
    beside an effect that is like a motor constant: what that leaves on its axes, the masses shift
    to the others.
    """
    if GAIN not in bench.effects or not bench.made.noise.repeats:
        return None
    if any(_kin(bench, effect.id) for effect in found):
        return None
    regression = bench.made.regression
    columns = [part.columns for effect in found for part in effect.parts]
    if columns:
        regression = regression.extended(columns)
    parts: list[Scored] = []
    while True:
        taken = {*closed, *(part.axis for part in parts)}
        part = _best(bench, regression, [i for i in range(bench.n) if i not in taken])
        if part is None:
            break
        parts.append(part)
        regression = regression.extended([part.columns])
    if not parts:
        return None
    return Found(GAIN, tuple(parts), (WARM,) if _warms(bench, found, parts) else ())


def _kin(bench: Bench, id: str) -> bool:
    """Whether an effect is confused with a motor constant by their own definitions."""
    if id not in bench.effects:
        return False
    mine, its = bench.effects[GAIN].effect, bench.effects[id].effect
    return id in mine.confused_with or GAIN in its.confused_with


def _best(bench: Bench, regression: Regression, axes: Sequence[int]) -> Scored | None:
    """The axis whose gain explains most, if by far more than any changed parameter."""
    made, spread = bench.made, dispersion(regression)
    strict = _strict(regression)
    scored = [_scored(bench, strict, GAIN, i, {}) for i in axes]
    certain = [s for s in scored if s.gain.p < LEVEL / bench.n and allowed(bench, s)]
    if not certain:
        return None
    best = max(certain, key=lambda s: s.gain.outside)
    known = best_change(regression, made.known, made.base.directions())
    return best if best.gain.outside > (known + FALL) * spread else None


def _warms(bench: Bench, found: Sequence[Found], parts: Sequence[Scored]) -> bool:
    """Whether motors that become warm explain about as much on the same axes."""
    if WARM not in bench.effects:
        return False
    columns = [part.columns for effect in found for part in effect.parts]
    regression = bench.made.regression
    strict = _strict(regression.extended(columns) if columns else regression)
    mine = its = 0.0
    for part in parts:
        assert part.axis is not None
        mine += strict.gain(part.columns).outside
        grid = [_scored(bench, strict, WARM, part.axis, s) for s in bench.effects[WARM].shapes]
        its += max(scored.gain.outside for scored in grid)
    return its >= CLOSE * mine


def _scored(
    bench: Bench, strict: Regression, id: str, axis: int, shape: dict[str, float]
) -> Scored:
    columns = bench.columns(id, axis, shape)
    return Scored(id, axis, shape, strict.gain(columns), columns)


def _strict(regression: Regression) -> Regression:
    """With parameters held by their own tolerances."""
    return replace(regression, prior=regression.prior * LOOSE**2 * dispersion(regression))
