"""What the mechanism lacks: searches until the base model settles beside what they find."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexhex.diagnosis.drives.drifts import drifts_of, without
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import Compiled
from flexhex.diagnosis.jointfit.beside import beside
from flexhex.diagnosis.jointfit.fit import EXPLAINED
from flexhex.diagnosis.jointfit.guard import moved, without_bent_delay, without_lags
from flexhex.diagnosis.jointfit.lagging import with_lag
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.residuals import Before, before_of
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.selection.criteria import USUAL as CRITERIA
from flexhex.diagnosis.selection.found import Found, found
from flexhex.diagnosis.selection.side import Side
from flexhex.numeric.memory import give_back

Say = Callable[[str], None]
SEARCHES = 3
"""Searches of the mechanism at most."""


def mechanism(
    model: Calibrated, known: Sequence[Compiled], judged: Sequence[Run], say: Say
) -> tuple[Before, Side]:
    """What the mechanism lacks, beside the base model as it settles; and what the first fit left.

    What is missing bends the fit of widths and delay, and a bent fit asks for effects that are not
    there; so the search begins anew beside the base model that its own answer leaves. If that finds
    what leaves more, the earlier answer stays.
    """
    now = found(Bench(model, known), judged, say)
    before = before_of(now.bench.model, now.others)
    now = _settling(now, known, say)
    side, least = now.side, (CRITERIA.deviations, CRITERIA.smallest_rest)
    # a single axis whose drive lags looks like a log whose torques are late
    lagging = with_lag(side.fit, least[0])
    if lagging is not None:
        left, freedom = now.left, now.freedom
        now.bench.forget()
        now = found(Bench(lagging, known), judged, say)
        simpler = (now.left <= left).all() and now.freedom <= freedom
        if simpler or np.nanprod((now.left / left) ** 2) < EXPLAINED:
            side, before = now.side, before_of(now.bench.model, now.others)
    if not side.remains:
        return before, side
    # what has no name bends a delay, and a bent delay leaves something on axes that lack nothing; a
    # lag of some axes looks like a delay of all
    bent, lags = without_bent_delay(side.fit, *least), without_lags(side.fit, least[0])
    for held, most in ((bent, np.inf), (lags, EXPLAINED)):
        if held is None or not side.remains:
            continue
        left = now.left
        now.bench.forget()
        now = found(Bench(held, known), judged, say)
        if np.nanprod((now.left / left) ** 2) < most:
            side, before = now.side, before_of(now.bench.model, now.others)
    return before, side


def steadily(
    first: Side, known: Sequence[Compiled], judged: Sequence[Run], say: Say
) -> tuple[Side, list[Side]]:
    """What the mechanism lacks without what changes from run to run, and that.

    A drift is fitted beside a model that it has bent, so once more beside the one that is fitted
    without it. If something repeats that nothing explains, with a drift and without it, it would be
    taken for one: then there is none.
    """
    now, drifts = first, drifts_of(first, judged)
    for _ in range(SEARCHES - 1):
        if not drifts or not (now.fit.parts or now.remains):
            break
        drift = drifts[0].fit
        model = without(now.fit, drift)
        now.fit.bench.model.forget()
        now = found(Bench(model, known), judged, say, drift).side
        drifts = drifts_of(now, judged)
        if not now.remains:
            break
    # what was taken off is told, and nothing else hid behind it
    good = drifts and not (first.remains and now.remains)
    return (now, drifts) if good else (first, [])


def _settling(now: Found, known: Sequence[Compiled], say: Say) -> Found:
    """The last of the searches beside the base model as what they find moves it."""
    for _ in range(SEARCHES - 1):
        # asked before the columns are gone: those of one search at a time take most of the memory
        left = now.left
        now.bench.forget()
        give_back()
        settled = _settled(now)
        if settled is None:
            break
        earlier, now = now, found(Bench(settled, known), now.judged, say)
        if np.nanprod((now.left / left) ** 2) > 1 / EXPLAINED:
            settled.forget()
            now.bench.forget()
            return earlier
    return now


def _settled(now: Found) -> Calibrated | None:
    """The base model beside what was found, if that moved it."""
    fit = now.fit
    anew = None if fit is None else beside(fit)
    if fit is None or anew is None:
        return None
    return anew if moved(fit.bench.model, anew, fit, CRITERIA.smallest_effect) else None
