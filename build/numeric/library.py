"""C text to a loaded shared library, kept by its content."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmugen import cache as store
from flexhex.fmugen.codegen import casadi_source
from flexhex.fmugen.compile import SMALL, compile_object, link_shared

Array = NDArray[np.float64]
FALLBACK = Path("out/cache")
"""Where libraries are kept when the user's cache cannot be written to."""


def loaded(
    text: str, stem: str, cache: Path | None = None, flags: Sequence[str] = ()
) -> ctypes.CDLL:
    """The library of a C text, out of `cache` where it was compiled before.

    cache: a folder; default: the objects of the user's cache, the same for every working folder.
    flags: further ones of the compiler. Raises BuildError when there is no compiler or it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / f"{stem}.c"
        source.write_text(text, encoding="utf-8")
        compiled = compile_object(source, "", cache or store.objects(FALLBACK), flags)
    library = compiled.with_suffix(".so")
    if not library.exists():
        link_shared([compiled], library)
    return ctypes.CDLL(str(library.resolve()))


def with_loops(
    functions: Sequence[ca.Function], loops: Sequence[str], stem: str, cache: Path | None
) -> ctypes.CDLL:
    """SX functions named `<stem>_<what>` and C loops over them, loaded.

    Their C is written once for all processes of a user: CasADi tells what they compute much faster
    than it is written. Raises BuildError as `loaded`.
    """

    def written() -> bytes:
        return (casadi_source(functions, stem, stem) + "".join(loops)).encode()

    same = store.key(store.sources(), [function.serialize() for function in functions], loops)
    text = store.kept("equations", f"{stem}-{same}", written).decode()
    return loaded(text, stem, cache, SMALL)


def short(function: ca.Function) -> str:
    """The name without its stem."""
    return str(function.name()).partition("_")[2]


def pointer(array: Array) -> ctypes.c_void_p:
    """Where a contiguous array begins."""
    return array.ctypes.data_as(ctypes.c_void_p)
