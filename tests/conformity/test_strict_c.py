"""C of every FMU, hand-written and generated: no warning of the whole program, no undefined step.

The optimiser sees all files of an FMU at once (-flto), so a call that hands over too small an
array, or a loop that leaves one, is found across files. The sanitizers find what depends on data.
"""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path

import pytest

from flexhex.fmugen.blocks import BLOCKS, build_block
from flexhex.fmugen.compile import compiler
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from tests.conformity.test_sources import HERE, run, unpack
from tests.conftest import OBJECTS, ROOT
from tests.effects.machines import everything

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror")
BOUNDS = ("-O2", "-ftree-vectorize", "-Warray-bounds=2", "-Wstringop-overflow", "-flto=1")
SANITIZERS = ("-O1", "-g", "-fsanitize=bounds,undefined", "-fno-sanitize-recover=all")
GENERATED = ("-Wno-unused-parameter", "-Wno-unused-function")
"""CasADi's functions all have one signature, and its helpers stand in every file."""
MACHINES = {"nominal": "tflex.toml", "axes": "tflex-actuators.toml"}
CASES = [
    *(("nominal", name) for name in (*BLOCKS, "machine")),
    *(("effects", name) for name in ("plant", "feedforward", "filter", "estimator")),
    ("axes", "plant"),
]
"""Effects bring code that the nominal machine does not have; a machine of axes alone has no d."""


@cache
def machine_of(kind: str) -> Machine:
    """The default machine, the one without a platform, the one with all effects."""
    return everything() if kind == "effects" else load_machine(ROOT / "machines" / MACHINES[kind])


def sources(kind: str, name: str, fmu_dir: Path, folder: Path) -> Path:
    """Folder with the C files of an FMU and the program that steps it."""
    fmu = fmu_dir / f"{name}.fmu"
    if kind != "nominal":
        fmu = build_block(name, machine_of(kind), folder, cache=OBJECTS)
    unpacked = unpack(fmu, folder) / "sources"
    for source in (HERE / "all.c", HERE.parent / "adapter" / "arena.h"):
        shutil.copyfile(source, unpacked / source.name)
    return unpacked


def program(folder: Path, name: str, *flags: str) -> Path:
    """The program of an FMU compiled with these flags, warnings being errors."""
    own = [*compiler(), *WARNINGS, *flags, "-DFLEXHEX_STATIC", "-fno-builtin"]
    by_hand = [p.name for p in sorted(folder.glob("*.c")) if p.name != f"{name}_casadi.c"]
    run([*own, f"-DFMUS(X)=X({name})", "-c", *by_hand], folder)
    if (folder / f"{name}_casadi.c").exists():
        run([*own, *GENERATED, "-c", f"{name}_casadi.c"], folder)
    objects = [p.name for p in sorted(folder.glob("*.o"))]
    run([*own, *objects, "-lm", "-o", "program"], folder)
    return folder / "program"


def is_gcc() -> bool:
    """Whether the compiler has gcc's warnings of the whole program."""
    return "Free Software Foundation" in run([*compiler(), "--version"], Path.cwd())


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), CASES)
def test_whole_program_gives_no_warning(
    fmu_dir: Path, tmp_path: Path, kind: str, name: str
) -> None:
    if not is_gcc():
        pytest.skip("these warnings are gcc's")
    program(sources(kind, name, fmu_dir, tmp_path), name, *BOUNDS)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), CASES)
def test_sanitizers_find_nothing_in_a_short_run(
    fmu_dir: Path, tmp_path: Path, kind: str, name: str
) -> None:
    folder = sources(kind, name, fmu_dir, tmp_path)
    words = run([str(program(folder, name, *SANITIZERS))], folder).split()
    assert words[0] == name
    assert words[words.index("bad") + 1] == "0"
