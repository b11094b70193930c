"""The clocks of one file beside each other."""

from __future__ import annotations

from flexhex.diagnosis.logs.clock import Clock
from flexhex.diagnosis.logs.log import Finding

DRIFT = 2e-6


def compared(where: str, clocks: dict[str, Clock]) -> list[Finding]:
    """What differs between the clocks of one file: rate, drift; none is changed by it.

    clocks: by the names of the channels on them.
    """
    notes: list[Finding] = []
    items = list(clocks.items())
    for name, clock in items[1:]:
        other, first = items[0]
        if clock.ts == first.ts:
            continue
        ratio = max(clock.ts, first.ts) / min(clock.ts, first.ts)
        whole = max(round(ratio), 1)
        off, seconds = ratio / whole - 1, clock.ts * clock.size
        if DRIFT < abs(off) < 0.01 and abs(off) * seconds > 0.5 * clock.ts:
            text = (
                f"the clocks of {name} and {other} drift by {abs(off) * 1e6:.4g} ppm,"
                f" {abs(off) * seconds * 1e3:.3g} ms over the run: each keeps its own times"
            )
            notes.append(Finding("drift", where, text, True))
        if whole > 1 or abs(off) >= 0.01:
            text = f"{name} every {clock.ts:.6g} s, {other} every {first.ts:.6g} s: kept apart"
            notes.append(Finding("rate", where, text, True))
    return notes
