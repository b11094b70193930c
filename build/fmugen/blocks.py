"""Build FMUs from their folders in `fmus/`, with other start values if wanted."""

from __future__ import annotations

import dataclasses
import importlib
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex import fmus
from flexhex.fmugen import cache as store
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmugen.compile import strict
from flexhex.fmugen.fmu import build_fmu
from flexhex.fmugen.pack import write_file
from flexhex.fmugen.platforms import host, tool
from flexhex.fmugen.sources import Generated
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface
from flexhex.fmus.common.machine.machine import Machine

Starts = Mapping[str, float | Sequence[float] | NDArray[np.float64]]
LIBRARIES = ("casadi", "numpy", "pydantic", "fmpy", "lxml")
"""Whose versions may change what is in an FMU."""
BLOCKS = (
    "reference", "pose", "kinematics", "feedforward", "feedback", "plant", "filter", "estimator",
)  # fmt: skip
_OF_PLATFORM = ("pose",)
"""FMUs that a machine without a platform does not have."""


def blocks(machine: Machine) -> tuple[str, ...]:
    """Folders of the FMUs of a machine."""
    return tuple(block for block in BLOCKS if machine.has_platform or block not in _OF_PLATFORM)


@lru_cache
def versions() -> tuple[tuple[str, str], ...]:
    """Installed versions of LIBRARIES."""
    return tuple((name, metadata.version(name)) for name in LIBRARIES)


def with_starts(interface: Interface, starts: Starts) -> Interface:
    """The interface with other start values of its parameters; InterfaceError for unknown names."""
    if "Ts" in starts:
        raise InterfaceError(
            f"{interface.name}: Ts is set by the machine file, not as a start value"
        )
    known = {v.name for v in interface.variables if v.causality == "parameter"}
    unknown = sorted(set(starts) - known)
    if unknown:
        raise InterfaceError(
            f"{interface.name} has no parameter {unknown[0]!r}; it has: {', '.join(sorted(known))}"
        )
    variables = tuple(
        dataclasses.replace(v, start=starts[v.name]) if v.name in starts else v
        for v in interface.variables
    )
    return dataclasses.replace(interface, variables=variables)


def block_interface(block: str, machine: Machine, starts: Starts | None = None) -> Interface:
    """Interface of an FMU for a machine, with start values replaced."""
    module: Any = importlib.import_module(f"flexhex.fmus.{block}.interface")
    with SYMBOLIC:
        return with_starts(module.interface(machine), starts or {})


def step_file(block: str) -> Path:
    """The hand-written step.c of an FMU."""
    return Path(fmus.__path__[0]) / block / "step.c"


def machine_interface(machine: Machine, truth: Path) -> Interface:
    """Interface of machine.fmu; MachineError for a wrong truth file."""
    from flexhex.fmus.machine import truth as real

    with SYMBOLIC:
        return real.interface(machine, real.load_truth(truth))


@dataclass(frozen=True)
class Source:
    """What an FMU is built from: a folder and a machine; with a truth file, machine.fmu.

    block: name of the folder in `fmus/`.
    """

    block: str
    machine: Machine
    truth: Path | None = None

    @property
    def name(self) -> str:
        """Name of the FMU."""
        return "machine" if self.truth else self.block

    def interface(self, starts: Starts | None = None) -> Interface:
        """Variables of the FMU, with start values replaced."""
        if self.truth is None:
            return block_interface(self.block, self.machine, starts)
        return with_starts(machine_interface(self.machine, self.truth), starts or {})

    def functions(self) -> Sequence[ca.Function]:
        """The equations; CasADi needs seconds for some."""
        with SYMBOLIC:
            if self.truth is None:
                module: Any = importlib.import_module(f"flexhex.fmus.{self.block}.equations")
                equations: Sequence[ca.Function] = module.functions(self.machine)
                return equations
            from flexhex.fmus.machine import truth as real

            return real.functions(self.machine, real.load_truth(self.truth))

    def headers(self) -> dict[str, str]:
        """C headers of machine.fmu that the plant's folder does not hold."""
        folder = Path(fmus.__path__[0], "machine")
        listed = sorted(folder.glob("*.h")) if self.truth else []
        return {path.name: path.read_text(encoding="utf-8") for path in listed}

    def build(
        self,
        out_dir: Path,
        starts: Starts | None = None,
        cache: Path | None = None,
        platforms: Sequence[str] = (),
    ) -> Path:
        """Build `out_dir/<name>.fmu` from nothing but object files in `cache`."""
        interface, equations = self.interface(starts), self.functions()
        return self._build(interface, equations, out_dir, cache, platforms)

    def build_kept(
        self,
        out_dir: Path,
        starts: Starts | None = None,
        cache: Path | None = None,
        platforms: Sequence[str] = (),
    ) -> Path:
        """The same FMU out of the cache of this user when nothing that it depends on changed.

        Other start values neither derive the equations again nor compile them. cache: folder for
        object files where the user's cache cannot be written to.
        """

        def build() -> bytes:
            interface = self.interface(starts)
            generated = Generated.loaded(
                store.kept("equations", f"{self.name}-{equations}", generate)
            )
            with tempfile.TemporaryDirectory() as scratch:
                folder = Path(scratch)
                objects = store.objects(cache or out_dir / "cache")
                return self._build(interface, generated, folder, objects, platforms).read_bytes()

        def generate() -> bytes:
            return Generated.of(self.interface(), self.functions(), self.block).dumped()

        equations = self._key()
        tools = [(name, tool(name)) for name in platforms or (host(),)]
        plain = {name: np.asarray(value).tolist() for name, value in (starts or {}).items()}
        whole = store.key(equations, tools, strict(), sorted(plain.items()))
        data = store.kept("fmus", f"{self.name}-{whole}", build)
        return write_file(out_dir / f"{self.name}.fmu", data)

    def _build(
        self,
        interface: Interface,
        equations: Sequence[ca.Function] | Generated,
        out_dir: Path,
        cache: Path | None,
        platforms: Sequence[str],
    ) -> Path:
        base, step = self.machine.timing.base, step_file(self.block)
        return build_fmu(
            interface, equations, step, out_dir, base, cache, platforms, self.headers()
        )

    def _key(self) -> str:
        """Hash of all that the equations depend on: our files, machine, truth, libraries."""
        truth = None
        if self.truth is not None:
            from flexhex.fmus.machine import truth as real

            truth = real.load_truth(self.truth)
        return store.key(store.sources(), sys.version, versions(), self.block, self.machine, truth)


def build_block(
    block: str,
    machine: Machine,
    out_dir: Path,
    starts: Starts | None = None,
    cache: Path | None = None,
    platforms: Sequence[str] = (),
) -> Path:
    """Build `out_dir/<block>.fmu`; starts: parameter name -> value(s) built in as defaults."""
    return Source(block, machine).build(out_dir, starts, cache, platforms)


def build_machine(
    machine: Machine,
    truth: Path,
    out_dir: Path,
    starts: Starts | None = None,
    cache: Path | None = None,
    platforms: Sequence[str] = (),
) -> Path:
    """Build `out_dir/machine.fmu`: the plant plus the effects of the truth file."""
    return Source("plant", machine, truth).build(out_dir, starts, cache, platforms)
