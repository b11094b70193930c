"""Effects that a run which was not fitted to speaks against."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.answer import (
    CERTAIN,
    EXPLAINED,
    GAP,
    Joint,
    repeat_rms,
)
from flexhex.diagnosis.elsewhere import Elsewhere
from flexhex.diagnosis.guard import kept_off, only


def not_worse(held: Joint, others: Elsewhere, notes: list[str]) -> Joint:
    """Withdraw effects, axis by axis, that make the locked runs worse."""
    kept = held.parts
    while kept:
        whole = others.squares(kept)
        falls = []
        for part in kept:
            rest = others.squares([p for p in kept if p is not part])
            axes = slice(None) if part.axis is None else part.axis
            falls.append(float(np.sum(rest[axes] - whole[axes])))
        worst = int(np.argmin(falls))
        if falls[worst] > 0:
            break
        part = kept.pop(worst)
        where = "" if part.axis is None else f" on axis {part.axis + 1}"
        notes.append(
            f"{part.id}{where} was withdrawn: it increases the residual of the held-out runs"
        )
    return held if len(kept) == len(held.parts) else only(held, kept)


def transferred(held: Joint, others: Elsewhere, notes: list[str]) -> Joint:
    """Keep effects off axes on which they leave most of what repeats in the locked runs: what
    fits one motion and not another imitates."""
    if not held.parts or not others.there.noise.repeats:
        return held
    before, _ = repeat_rms(others.there, others.residual((), (), held.bench.made.regression.q))
    after, certain = repeat_rms(others.there, others.residual(held.parts, held.beta, held.q))
    open_ = (certain > CERTAIN) & (after > GAP * held.bench.made.torque_rms)
    poor = [
        i
        for i in sorted({part.axis for part in held.parts if part.axis is not None})
        if open_[i] and after[i] ** 2 > (1 - EXPLAINED) * before[i] ** 2
    ]
    for i in poor:
        names = ", ".join(dict.fromkeys(part.id for part in held.parts if part.axis == i))
        notes.append(
            f"{names} on axis {i + 1} fits the runs, but {after[i] / before[i]:.0%} of the"
            " repeatable residual remains on the held-out runs: not reported"
        )
    return kept_off(held, poor) if poor else held
