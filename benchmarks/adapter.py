"""What the FMI adapter costs: an idle doStep with 100 values set and 100 got."""

from __future__ import annotations

import ctypes
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blocks import CACHE, HERE, harness, starts
from benchmarks.clock import Rival, Row, measure
from flexhex.fmugen.blocks import block_interface, build_block
from flexhex.fmugen.compile import HIDDEN, LOOPS, STRICT, compile_object, link_shared
from flexhex.fmugen.fmu import FMI
from flexhex.fmugen.sources import variables
from flexhex.fmus.common.machine.machine import Machine
from flexhex.ssp.fmu import binary_path, read_fmu

N = 100


class _Slave(ctypes.Structure):
    """slave of harness.c."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("set", "step", "get", "c", "inputs", "outputs")),
        ("n", ctypes.c_size_t),
        ("values", ctypes.c_void_p),
        ("base", ctypes.c_double),
        ("done", ctypes.c_long),
    )


class _Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions without any: the FMU then uses the C library's own."""

    _fields_ = tuple((name, ctypes.c_void_p) for name in ("log", "make", "free", "end", "more"))


class Slave:
    """N values in, a base step, N values out, over and over."""

    def __init__(
        self, functions: tuple[Any, Any, Any], c: int, first: tuple[int, int], values: Any,
        base: float,
    ) -> None:  # fmt: skip
        self.keep = [
            np.arange(first[0], first[0] + N, dtype=np.uint32),
            np.arange(first[1], first[1] + N, dtype=np.uint32),
            np.concatenate([values, np.zeros(N)]),
        ]
        at = [array.ctypes.data for array in self.keep]
        pointers = [ctypes.cast(f, ctypes.c_void_p) for f in functions]
        self.c = _Slave(*pointers, c, at[0], at[1], N, at[2], base, 0)

    def run(self, count: int) -> float:
        """So many base steps; ns for one. ValueError when a call was refused."""
        spent = float(harness().bench_slave(ctypes.byref(self.c), ctypes.c_long(count)))
        if spent < 0:
            raise ValueError("a call was refused: the time would mean nothing")
        return spent


def ours(machine: Machine) -> Slave:
    """The estimator's FMU, which waits: its t_start is never reached."""
    interface = block_interface("estimator", machine)
    file = build_block("estimator", machine, CACHE / "fmus", {"t_start": 1e6}, CACHE)
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(file) as archive:
        library = ctypes.CDLL(archive.extract(binary_path("estimator"), folder))
    guid = read_fmu(file.read_bytes(), file.name).guid
    callbacks = _Callbacks()
    instantiate = library.fmi2Instantiate
    instantiate.restype = ctypes.c_void_p
    c = instantiate(b"K", 1, guid.encode(), b"", ctypes.byref(callbacks), 0, 0)
    pointer = ctypes.c_void_p(c)
    library.fmi2SetupExperiment(
        pointer, 0, ctypes.c_double(0.0), ctypes.c_double(0.0), 0, ctypes.c_double(0.0)
    )
    for call in ("fmi2EnterInitializationMode", "fmi2ExitInitializationMode"):
        if getattr(library, call)(pointer):
            raise ValueError(f"{call} was refused")
    first_input = sum(v.count for v in interface.parameters)
    listed = variables(interface)
    first_output = sum(v.count for v in listed if v.causality != "output")
    calls = (library.fmi2SetReal, library.fmi2DoStep, library.fmi2GetReal)
    values = starts(interface.inputs)[:N]
    return Slave(calls, c, (first_input, first_output), values, machine.timing.base)


def switching(machine: Machine) -> Slave:
    """The rival of switching.c, compiled with the same flags."""
    flags = (*STRICT, *HIDDEN, *LOOPS, f"-I{FMI}")
    compiled = compile_object(HERE / "switching.c", "", CACHE, flags)
    path: Path = link_shared([compiled], compiled.with_suffix(".so"))
    library = ctypes.CDLL(str(path.resolve()))
    library.switching_instance.restype = ctypes.c_void_p
    calls = (library.switching_set, library.switching_step, library.switching_get)
    return Slave(calls, library.switching_instance(), (0, N), np.zeros(N), machine.timing.base)


def adapter_row(machine: Machine, rounds: int) -> Row:
    """Set 100, idle doStep, get 100."""
    rivals = [
        Rival("adapter", ours(machine).run),
        Rival("switch per value", switching(machine).run, "checks nothing"),
    ]
    what = f"FMU adapter: set {N}, idle doStep, get {N}"
    return Row("adapter", what, measure(rivals, rounds), 500, 200)
