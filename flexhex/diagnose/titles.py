"""What effects and axes are called in a sentence."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache

from flexhex.diagnose.numbers import listed
from flexhex.fmus.common.effects import library

COUNTED = (
    *("harmonic", "lag", "delay", "force", "mode"),
    *("hysteresis", "base", "ring", "joint", "limit"),
)
"""Last words of titles that want an article."""


@cache
def title(effect: str) -> str:
    """Title of an effect of the library; its id where there is none of that name."""
    return library()[effect].title if effect in library() else effect.replace("_", " ")


def phrase(effect: str) -> str:
    """Its title with an article where one is wanted: `a flexible mode`, `Coulomb friction`."""
    text = title(effect)
    head = text.split(" of ")[0].split(" with ")[0]
    counted = head.endswith(COUNTED) or head == "error"
    return f"{'an' if text[0] in 'aeiou' else 'a'} {text}" if counted else text


def readable(text: str) -> str:
    """A note with titles in place of ids: `Coulomb friction on axis 3`. Parameters keep their
    names, `cogging_harmonic.a[2]`."""
    return spaced(_ids().sub(lambda found: title(found[0]), text))


def spaced(text: str) -> str:
    """`5 %` of `5%`."""
    return re.sub(r"(?<=\d)%", " %", text)


@cache
def _ids() -> re.Pattern[str]:
    return re.compile(rf"\b({'|'.join(sorted(library()))})\b(?![\[#]|\.\w)")


def where(axes: Sequence[int], short: bool = False) -> str:
    """`axis 3`, `axes 2 and 5`, `the machine as a whole`."""
    if not axes:
        return "whole" if short else "the machine as a whole"
    if len(axes) == 1:
        return f"axis {axes[0]}"
    return f"axes {listed([str(a) for a in axes])}"


def capital(text: str) -> str:
    """The first letter in capitals, the others as they are."""
    return text[:1].upper() + text[1:]


def effort(units: Sequence[str]) -> str:
    """What axes with these units have: torque, force, voltage, or several."""
    called = {"N m": "torque", "V": "voltage"}
    return " or ".join(dict.fromkeys(called.get(unit, "force") for unit in units))
