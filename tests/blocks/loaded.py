"""A block's step.c compiled and called directly: its structs as NumPy views, its state in sight.

What the FMI adapter adds (sample times, checks of values) has tests of its own.
"""

from __future__ import annotations

import ctypes
import importlib
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.fmugen import codegen, sources
from flexhex.fmugen.blocks import block_interface, step_file
from flexhex.fmugen.compile import HIDDEN, LOOPS, SMALL, compile_object, link_shared, strict
from flexhex.fmugen.fmu import RUNTIME
from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from tests.conftest import OBJECTS

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[2]
_START = ctypes.CFUNCTYPE(
    ctypes.c_bool, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p,
    ctypes.c_size_t,
)  # fmt: skip
_TICK = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class _Block(ctypes.Structure):
    """flexhex_block of block.h."""

    _fields_ = (
        ("parameters", ctypes.c_size_t),
        ("inputs", ctypes.c_size_t),
        ("outputs", ctypes.c_size_t),
        ("state", ctypes.c_size_t),
        ("start", _START),
        ("tick", _TICK),
    )


class StartError(Exception):
    """start() refused the parameters."""


class Struct:
    """A C struct of doubles by variable name; scalars read as floats."""

    def __init__(self, variables: Sequence[Variable]) -> None:
        self.size = sum(v.count for v in variables)
        self.values = np.zeros(max(self.size, 1))
        self._slices: dict[str, tuple[int, int | None]] = {}
        at = 0
        for v in variables:
            self._slices[v.name] = (at, v.size)
            self.values[at : at + v.count] = v.starts
            at += v.count

    def __getitem__(self, name: str) -> Any:
        at, size = self._slices[name]
        return float(self.values[at]) if size is None else self.values[at : at + size].copy()

    def __setitem__(self, name: str, value: Any) -> None:
        at, size = self._slices[name]
        self.values[at : at + (size or 1)] = value

    @property
    def pointer(self) -> int:
        return int(self.values.ctypes.data)


class Loaded:
    """One instance of a block: `start` once, then `tick` with named inputs."""

    def __init__(self, library: Path, interface: Interface) -> None:
        self.interface = interface
        self._library = ctypes.CDLL(str(library))
        self._block = _Block.in_dll(self._library, f"{interface.name}_block")
        self.p = Struct(interface.parameters)
        self.u, self.y = Struct(interface.inputs), Struct(interface.outputs)
        sizes = (self._block.parameters, self._block.inputs, self._block.outputs)
        assert sizes == tuple(8 * s.values.size for s in (self.p, self.u, self.y))
        self.state = np.full(self._block.state // 8, np.nan)

    def start(self, **parameters: Any) -> Struct:
        """Set parameters, start; raises StartError with the block's message."""
        for name, value in parameters.items():
            self.p[name] = value
        text = ctypes.create_string_buffer(256)
        good = self._block.start(
            self.p.pointer, self.state.ctypes.data, self.y.pointer, text, len(text)
        )
        if not good:
            raise StartError(text.value.decode())
        return self.y

    def tick(self, **inputs: Any) -> Struct:
        """One tick with these inputs changed; the outputs."""
        for name, value in inputs.items():
            self.u[name] = value
        self._block.tick(self.p.pointer, self.u.pointer, self.state.ctypes.data, self.y.pointer)
        return self.y


@cache
def machine() -> Machine:
    """The default machine."""
    return load_machine(ROOT / "machines" / "tflex.toml")


@cache
def build(block: str, of: Machine, flags: tuple[str, ...] = ()) -> tuple[Path, Interface]:
    """Shared library and interface of a block, compiled as the FMU's own sources are; only the
    symbols of step.c are not hidden, since they are called here. flags: for step.c."""
    equations: Any = importlib.import_module(f"flexhex.fmus.{block}.equations")
    interface, functions = block_interface(block, of), equations.functions(of)
    step = step_file(block)
    texts = {
        f"{block}.h": sources.header(interface, functions, block),
        **{
            name: (RUNTIME / name).read_text(encoding="utf-8")
            for name in ("block.h", "pair.h", "wide.h")
        },
        **{path.name: path.read_text(encoding="utf-8") for path in step.parent.glob("*.h")},
        f"{block}_step.c": step.read_text(encoding="utf-8"),
        f"{block}_casadi.c": codegen.casadi_source(functions, block, block),
    }
    headers = "\0".join(text for name, text in texts.items() if name.endswith(".h"))
    with tempfile.TemporaryDirectory(dir=OBJECTS) as folder:
        work = Path(folder)
        for name, text in texts.items():
            (work / name).write_text(text, encoding="utf-8")
        objects = [
            compile_object(work / f"{block}_casadi.c", "", OBJECTS, (*HIDDEN, *SMALL)),
            compile_object(work / f"{block}_step.c", headers, OBJECTS, (*LOOPS, *strict(), *flags)),
        ]
        library = OBJECTS / ("-".join(path.stem for path in objects) + ".so")
        return link_shared(objects, library), interface


def load(block: str, of: Machine | None = None, flags: tuple[str, ...] = ()) -> Loaded:
    """A fresh instance of a block, not yet started; of the default machine."""
    return Loaded(*build(block, of or machine(), flags))
