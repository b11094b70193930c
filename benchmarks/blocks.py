"""Blocks compiled as in their FMUs, called in timing loops in C (harness.c)."""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmugen import codegen, sources
from flexhex.fmugen.blocks import block_interface, step_file
from flexhex.fmugen.compile import HIDDEN, LOOPS, SMALL, STRICT, compile_object, link_shared
from flexhex.fmugen.fmu import FMI, RUNTIME
from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine

Array = NDArray[np.float64]
HERE = Path(__file__).resolve().parent
CACHE = Path("out") / "cache" / "benchmarks"
_EXPORT = """#include "block.h"
extern const flexhex_block {name}_block;
__attribute__((visibility("default"))) const void *bench_block(void);
const void *bench_block(void) {{ return &{name}_block; }}
"""
_START = ctypes.CFUNCTYPE(
    ctypes.c_bool, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p,
    ctypes.c_size_t,
)  # fmt: skip


class _Block(ctypes.Structure):
    """flexhex_block of block.h."""

    _fields_ = (
        *((name, ctypes.c_size_t) for name in ("parameters", "inputs", "outputs", "state")),
        ("start", _START),
        ("tick", ctypes.c_void_p),
    )


class _Instance(ctypes.Structure):
    """instance of harness.c."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("block", "p", "u", "s", "y")),
        ("rows", ctypes.c_long),
        ("at", ctypes.c_long),
    )


@cache
def harness(cache: Path = CACHE) -> ctypes.CDLL:
    """The timing loops; every function returns nanoseconds [ns] for one call."""
    flags = (*STRICT, f"-I{RUNTIME}", f"-I{FMI}")
    compiled = compile_object(HERE / "harness.c", _digest([RUNTIME / "block.h"]), cache, flags)
    library = ctypes.CDLL(str(link_shared([compiled], compiled.with_suffix(".so")).resolve()))
    for name in ("bench_ticks", "bench_chain", "bench_slave", "bench_two_pointers"):
        getattr(library, name).restype = ctypes.c_double
    return library


def _digest(paths: Sequence[Path]) -> str:
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in paths)).hexdigest()


def library(
    interface: Interface,
    functions: Sequence[ca.Function],
    step: Path,
    cache: Path = CACHE,
    flags: Sequence[str] = (),
) -> Path:
    """Shared library of one block: step.c, its header, generated code; flags: for step.c."""
    name, block = interface.name, interface.name
    texts = {path.name: path.read_text(encoding="utf-8") for path in step.parent.glob("*.h")}
    for header in ("block.h", "pair.h", "wide.h"):
        texts[header] = (RUNTIME / header).read_text(encoding="utf-8")
    texts[f"{block}.h"] = sources.header(interface, functions, block)
    headers = "\0".join(texts[key] for key in sorted(texts))
    texts[f"{name}_step.c"] = step.read_text(encoding="utf-8")
    texts[f"{name}_casadi.c"] = codegen.casadi_source(functions, block, name)
    texts[f"{name}_export.c"] = _EXPORT.format(name=name)
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=cache) as folder:
        work = Path(folder)
        for key, text in texts.items():
            (work / key).write_text(text, encoding="utf-8")
        more = (*HIDDEN, *LOOPS, *STRICT)
        objects = [
            compile_object(work / f"{name}_casadi.c", "", cache, (*HIDDEN, *SMALL)),
            compile_object(work / f"{name}_step.c", headers, cache, (*more, *flags)),
            compile_object(work / f"{name}_export.c", headers, cache, HIDDEN),
        ]
        key = hashlib.sha256("".join(path.name for path in objects).encode()).hexdigest()[:24]
        return link_shared(objects, cache / f"{name}-{key}.so")


class Instance:
    """A started instance of a block that takes rows of inputs (rows, inputs) in turn."""

    def __init__(self, path: Path, interface: Interface, rows: Array, **parameters: Any) -> None:
        self.interface, self._library = interface, ctypes.CDLL(str(path.resolve()))
        self._library.bench_block.restype = ctypes.c_void_p
        address = self._library.bench_block()
        block = _Block.from_address(address)
        self.p, self.rows = starts(interface.parameters), np.ascontiguousarray(rows)
        if self.rows.shape[1] * 8 != block.inputs:
            raise ValueError(f"{interface.name}: {self.rows.shape[1]} inputs, C has {block.inputs}")
        for name, value in parameters.items():
            self.p[place(interface.parameters, name)] = value
        self.y, self.s = np.zeros(block.outputs // 8), np.zeros(block.state // 8)
        message = ctypes.create_string_buffer(256)
        if not block.start(*map(_at, (self.p, self.s, self.y)), message, len(message)):
            raise ValueError(message.value.decode())
        self.c = _Instance(address, *map(_at, (self.p, self.rows, self.s, self.y)), len(rows), 0)

    def ticks(self, count: int) -> float:
        """Run so many ticks; ns for one."""
        return float(harness().bench_ticks(ctypes.byref(self.c), ctypes.c_long(count)))

    def output(self, name: str) -> Array:
        """Current value of an output."""
        return self.y[place(self.interface.outputs, name)].copy()


def block(
    name: str, machine: Machine, rows: Array, flags: Sequence[str] = (), **parameters: Any
) -> Instance:
    """Instance of one of the house's blocks; flags: for step.c."""
    equations: Any = importlib.import_module(f"flexhex.fmus.{name}.equations")
    interface = block_interface(name, machine)
    path = library(interface, equations.functions(machine), step_file(name), flags=flags)
    return Instance(path, interface, rows, **parameters)


def starts(variables: Sequence[Variable]) -> Array:
    """Start values of variables, as the C struct holds them."""
    return np.array([value for v in variables for value in v.starts] or [0.0])


def place(variables: Sequence[Variable], name: str) -> slice:
    """Where a variable stands in its C struct; KeyError when it does not."""
    at = 0
    for v in variables:
        if v.name == name:
            return slice(at, at + v.count)
        at += v.count
    raise KeyError(name)


def operations(name: str, machine: Machine) -> dict[str, int]:
    """Operations of each generated function of a block, as CasADi counts them."""
    equations: Any = importlib.import_module(f"flexhex.fmus.{name}.equations")
    listed: Sequence[ca.Function] = equations.functions(machine)
    return {f.name(): codegen.straight_line(f, f.name()).n_instructions() for f in listed}


def _at(array: Array) -> int:
    return int(array.ctypes.data)
