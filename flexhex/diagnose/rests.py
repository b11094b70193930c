"""What repeats, or is left, beside all that is named, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from flexhex.diagnose.numbers import listed, number
from flexhex.diagnose.sizes import SEVERAL
from flexhex.diagnose.titles import effort, phrase, where
from flexhex.diagnosis.result.rest import Rest


def unexplained(rests: Sequence[Rest]) -> str:
    """How far the library explains what remains."""
    part = all(rest.fitted_share > 0 for rest in rests)
    return "the library explains only in part" if part else "no effect of the library explains"


def verb(rests: Sequence[Rest]) -> str:
    """That it repeats, where passes of the same motion show that."""
    return "repeats" if all(rest.repeats for rest in rests) else "is left"


def sizes_of(rests: Sequence[Rest]) -> str:
    """`0.3 N m (2 % of its torque) on axis 1`, the largest shares first, a few of them."""
    first = sorted(rests, key=lambda rest: -rest.share)
    texts = []
    for rest in first[:SEVERAL]:
        force = effort([rest.unit])
        share = f"{number(100 * rest.share, 2)} % of its {force}"
        goes = f", which goes with {rest.what}" if rest.what else ""
        names, part = listed([phrase(f) for f in rest.fitted]), number(100 * rest.fitted_share, 2)
        names = names if len(rest.fitted) <= SEVERAL else f"{len(rest.fitted)} effects together"
        fits = f" (of its mean square {names} would explain {part} %)" if names else ""
        texts.append(f"{number(rest.rms, 2)} {rest.unit} ({share}) on axis {rest.axis}{goes}{fits}")
    more = [f"less on {where(sorted(r.axis for r in first[SEVERAL:]))}"] if first[SEVERAL:] else []
    return listed([*texts, *more])
