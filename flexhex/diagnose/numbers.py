"""Numbers for a person: as many digits as are known."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flexhex.diagnosis.kinds import with_unit
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.output.tables import printed


def number(value: float, digits: int = 3) -> str:
    """Significant digits without an exponent where that is readable."""
    if not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    place = digits - 1 - math.floor(math.log10(abs(value)))
    if not -4 <= place - digits < 4:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        return f"{mantissa}e{int(power)}"
    return f"{value:.{max(place, 0)}f}"


def settled(e: Estimate) -> float:
    """The value, or 0 where it is less than a thousandth of its interval: noise of the fit."""
    half = 0.5 * (e.ci95[1] - e.ci95[0])
    return e.value if abs(e.value) > 1e-3 * half else 0.0


def measured(e: Estimate) -> str:
    """`0.050 ± 0.003 N m`, `(3.7 ± 0.3)e-5 s`: the digits are those of the interval; unit 1 is left
    out."""
    unit = with_unit("", printed(e.unit))
    low, high = e.ci95
    half = 0.5 * (high - low)
    if not e.determined:
        return f"{number(e.value)}{unit} (not determined)"
    if not half > 0:
        whole = e.value == round(e.value) and abs(e.value) < 1000
        return (f"{e.value:.0f}" if whole else number(e.value)) + unit
    lopsided = abs(high + low - 2 * e.value) > 0.2 * (high - low)
    place = -math.floor(math.log10(half)) + (f"{half:e}"[0] == "1")
    ten = math.floor(math.log10(max(abs(e.value), half)))
    if ten < -3 and not lopsided:
        digits = max(place + ten, 0)
        value = round(e.value / 10**ten, digits) + 0.0
        return f"({value:.{digits}f} ± {half / 10**ten:.{digits}f})e{ten}{unit}"
    if place < -3 or lopsided:
        value, start, end = _alike(e.value, low, high)
        return f"{value}{unit} ({start} to {end}{unit})"
    digits = max(place, 0)
    return f"{e.value:.{digits}f} ± {half:.{digits}f}{unit}"


def _alike(*values: float) -> list[str]:
    """Numbers with the power of ten of the largest, if it needs one: `0.23e-5`, `0`, `1.10e-5`.
    One that is less than a hundredth of it has its own."""
    largest = max((abs(v) for v in values if math.isfinite(v)), default=0.0)
    _, e, power = number(largest).partition("e")
    size = 10 ** int(power or 0)
    if not e:
        return [number(v) for v in values]
    return [f"{number(v / size)}e{power}" if abs(v) > size / 100 else number(v) for v in values]


def side_by_side(e: Estimate) -> tuple[str, str]:
    """`0.00308` and `0.00307 to 0.00309`, `2e-6` and `(-11 to 14)e-6`: with as many digits as tell
    the ends apart to two of their own, and with the same power of ten."""
    ends = e.ci95
    width = ends[1] - ends[0]
    if not 0 < width < math.inf:
        return number(e.value, 4), f"{number(ends[0])} to {number(ends[1])}"
    value = settled(e)
    ten = math.floor(math.log10(max(map(abs, (value, *ends)))))
    ten = 0 if -4 <= ten < 5 else ten
    digits = max(1 - math.floor(math.log10(width)) + ten, 0)
    own, low, high = (f"{round(v / 10**ten, digits) + 0.0:.{digits}f}" for v in (value, *ends))
    power = f"e{ten}" if ten else ""
    return own + power, f"({low} to {high}){power}" if ten else f"{low} to {high}"


def rounded(e: Estimate, value: float) -> str:
    """An estimate, or what is proportional or inverse to it, with as many digits as its interval
    knows, four at most."""
    low, high = e.ci95
    half = 0.5 * (high - low) * abs(value / e.value) if e.value else math.nan
    digits = 4
    if 0 < half < math.inf:
        known = math.floor(math.log10(abs(value))) - math.floor(math.log10(half)) + 1
        digits = min(max(known + (f"{half:e}"[0] == "1"), 1), digits)
    return f"{float(f'{value:.{digits}g}'):.4g}"


def percent(share: float) -> str:
    """A share as a whole percentage; never 100 % unless it is."""
    if not math.isfinite(share):
        return "–"
    whole = round(100 * share)
    return f"{99 if whole == 100 and share < 0.9995 else whole} %"


def listed(words: Sequence[str], last: str = "and") -> str:
    """`a, b and c`."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"
