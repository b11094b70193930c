"""Errors in the words of the Python interface: `--rename a=theta[1]` becomes
`rename={'a': 'theta[1]'}`."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from flexhex.fmus.common.errors import FlexhexError

P = ParamSpec("P")
T = TypeVar("T")
ARGUMENTS = {
    "rename": "rename",
    "unit": "units",
    "torque-constant": "torque_constant",
    "motor": "motor",
    "tolerance": "tolerance",
    "base": "base",
    "joints": "joints",
    "effect": "effects",
    "diagnosis": "diagnosis",
    "machine": "machine",
    "held-out": "held_out",
    "write": "path",
    "fmu": "path",
    "next": "path",
}
"""What each option of the command line is called in Python."""
OPTION = re.compile(rf"--({'|'.join(ARGUMENTS)})\b")
PAIR = re.compile(r"--(rename|unit|tolerance) (?:'([^'=]+)=([^']+)'|([^\s'=]+)=([^\s,;:)]+))")


def in_python(function: Callable[P, T]) -> Callable[P, T]:
    """The same function; what its errors say of options, they say of its arguments."""

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except FlexhexError as error:
            error.args = (translated(str(error)),)
            raise

    return called


def translated(text: str) -> str:
    """A sentence without options of the command line."""
    text = PAIR.sub(_pair, text.replace("with --fmu", "as an FMU"))
    return OPTION.sub(lambda option: ARGUMENTS[option[1]], text)


def _pair(found: re.Match[str]) -> str:
    key, value = found[2] or found[4], found[3] or found[5]
    shown = value if found[1] == "tolerance" else repr(value)
    return f"{ARGUMENTS[found[1]]}={{{key!r}: {shown}}}"
