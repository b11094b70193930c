"""The C executor as Python sees it: compiled on first use, structures as in executor.h."""

from __future__ import annotations

import ctypes
import hashlib
from ctypes import (
    POINTER,
    Structure,
    c_bool,
    c_char_p,
    c_double,
    c_int64,
    c_size_t,
    c_uint,
    c_void_p,
)
from functools import lru_cache
from pathlib import Path

from flexhex.fmugen import cache as store
from flexhex.fmugen.compile import compile_object, link_shared, strict
from flexhex.fmugen.fmu import FMI

HERE = Path(__file__).resolve().parent
FALLBACK = Path("out/lib")
"""Where the executor is kept when the user's cache cannot be written to."""


class Variables(Structure):
    """executor_variables."""

    _fields_ = (
        ("n_reals", c_size_t),
        ("n_integers", c_size_t),
        ("n_booleans", c_size_t),
        ("references", POINTER(c_uint)),
    )


class ComponentData(Structure):
    """executor_component."""

    _fields_ = (
        ("name", c_char_p),
        ("library", c_char_p),
        ("functions", c_void_p),
        ("guid", c_char_p),
        ("resources", c_char_p),
        ("period", c_int64),
        ("parameters", Variables),
        ("values", POINTER(c_double)),
        ("inputs", Variables),
        ("sources", POINTER(c_size_t)),
        ("outputs", Variables),
        ("slot", c_size_t),
        ("n_categories", c_size_t),
        ("categories", POINTER(c_char_p)),
    )


class LogData(Structure):
    """executor_log."""

    _fields_ = (
        ("period", c_int64),
        ("n_slots", c_size_t),
        ("slots", POINTER(c_size_t)),
        ("rows", c_void_p),
        ("capacity", c_size_t),
        ("count", c_size_t),
    )


class TimesData(Structure):
    """executor_times."""

    _fields_ = (
        ("seconds", c_double),
        ("worst", c_double),
        ("steps", ctypes.c_uint64),
        ("warnings", ctypes.c_uint64),
    )


def build(cache: Path) -> Path:
    """Compile the executor into cache unless the same sources are there; BuildError."""
    headers = [HERE / "executor.h", *sorted(FMI.glob("*.h"))]
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in headers)).hexdigest()
    flags = (*strict(), f"-I{FMI}")
    compiled = compile_object(HERE / "executor.c", digest, cache, flags)
    library = compiled.with_suffix(".so")
    return library if library.exists() else link_shared([compiled], library, ("-ldl",))


@lru_cache
def load(cache: Path | None = None) -> ctypes.CDLL:
    """The loaded library with its signatures; calls release the interpreter's lock.

    cache: where it is compiled, default the objects of the user's cache.
    """
    library = ctypes.CDLL(str(build(cache or store.objects(FALLBACK)).resolve()))
    library.executor_open.restype = c_void_p
    library.executor_open.argtypes = (
        POINTER(ComponentData),
        c_size_t,
        c_size_t,
        c_double,
        POINTER(LogData),
        c_size_t,
        c_bool,
        c_char_p,
        c_size_t,
    )
    library.executor_play.restype = None
    library.executor_play.argtypes = (c_void_p, c_void_p, c_size_t, c_size_t, c_size_t)
    library.executor_run.restype = c_bool
    library.executor_run.argtypes = (c_void_p, c_int64)
    library.executor_message.restype = c_char_p
    library.executor_message.argtypes = (c_void_p,)
    library.executor_bus.restype = POINTER(c_double)
    library.executor_bus.argtypes = (c_void_p,)
    library.executor_time_of.restype = TimesData
    library.executor_time_of.argtypes = (c_void_p, c_size_t)
    library.executor_warning_of.restype = c_char_p
    library.executor_warning_of.argtypes = (c_void_p, c_size_t)
    library.executor_close.restype = None
    library.executor_close.argtypes = (c_void_p,)
    return library
