"""The sources of an FMU: one compiler call, CMake, FMPy, and all FMUs in one program."""

from __future__ import annotations

import ctypes as ct
import shutil
import struct
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from flexhex.check.binary import make_plan
from flexhex.check.slave import Instance
from flexhex.check.subject import Subject
from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmugen.compile import HIDDEN, SMALL, compile_object, compiler
from flexhex.fmugen.page import BUILD
from tests.conformity.archives import members
from tests.conftest import OBJECTS

HERE = Path(__file__).parent
NAMES = (*BLOCKS, "machine")
STATIC = ("-DFLEXHEX_STATIC",)
STRICT = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror")
STEPS, BASE = 1000, 0.00025


def sampled(one: str) -> list[Any]:
    """All FMUs, but one of them only in the short tests."""
    return [one, *(pytest.param(n, marks=pytest.mark.slow) for n in NAMES if n != one)]


def run(command: Sequence[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout


def unpack(fmu: Path, folder: Path) -> Path:
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    return folder


def plan_of(fmu: Path, folder: Path, library: Path | None = None) -> dict[str, Any]:
    """Plan for an unpacked FMU, with its own binary or another one."""
    plan = make_plan(Subject.open(fmu), folder, f"binaries/linux64/{fmu.stem}.so")
    return {**plan, "library": str(library or plan["library"])}


def course(plan: dict[str, Any], steps: int = STEPS) -> int:
    """The course of all.c with a shared library: hash of all outputs."""
    instance, hashed = Instance(ct.CDLL(plan["library"]), plan), 0xCBF29CE484222325
    assert instance.initialise(), instance.last
    inputs = [v for v in plan["variables"] if v["causality"] == "input"]
    outputs = [v["reference"] for v in plan["variables"] if v["causality"] == "output"]
    references = [v["reference"] for v in inputs]
    for n in range(steps):
        values = []
        for v in inputs:
            wanted = v["start"] + 1e-3 * ((n * 7 + v["reference"][1]) % 11 - 5)
            low = wanted if v["min"] is None else max(wanted, v["min"])
            values.append(low if v["max"] is None else min(low, v["max"]))
        assert instance.set(references, values), instance.last
        assert instance.step(n * BASE, BASE), instance.last
        row = instance.get(outputs)
        assert row is not None
        for byte in struct.pack(f"{len(row)}d", *row):
            hashed = (hashed ^ byte) * 0x100000001B3 % 2**64
    instance.free()
    return hashed


@pytest.fixture(scope="module")
def together(fmu_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, int]:
    """What the program with all FMUs prints."""
    folder = tmp_path_factory.mktemp("all")
    objects = []
    for name in NAMES:
        sources = unpack(fmu_dir / f"{name}.fmu", folder / name) / "sources"
        headers = "\0".join(p.read_text() for p in sorted(sources.glob("*.h")))
        for source in sorted(sources.glob("*.c")):
            generated = source.name.endswith("_casadi.c")
            # equations are those of the shared library: they know of nothing else
            seen, flags = ("", (*HIDDEN, *SMALL)) if generated else (headers + name, STATIC)
            objects.append(compile_object(source, seen, OBJECTS, flags))
    for source in (HERE / "all.c", HERE.parent / "adapter" / "arena.h"):
        shutil.copyfile(source, folder / source.name)
    headers = f"-I{folder / 'plant' / 'sources'}"
    # no builtin: the compiler must not take the program's calloc for the library's
    main = [*compiler(), *STRICT, "-fno-builtin", headers, "all.c", *map(str, objects)]
    run([*main, "-lm", "-o", "all"], folder)
    words = run([str(folder / "all")], folder).split()
    return {name: int(value, 16) for name, value in zip(words[::2], words[1::2], strict=True)}


def test_all_fmus_link_and_step_in_one_program(together: dict[str, int]) -> None:
    assert set(NAMES) < set(together)
    assert together["bad"] == 0


def test_no_step_of_any_fmu_allocates(together: dict[str, int]) -> None:
    """Initialisation and 1000 base steps of each, libc's own allocations counted too."""
    assert together["at_start"] >= len(NAMES), "the count counts"
    assert together["allocated"] == 0


@pytest.mark.parametrize("name", ["feedback", "kinematics"])
def test_statically_linked_equals_the_binary(
    together: dict[str, int], fmu_dir: Path, tmp_path: Path, name: str
) -> None:
    fmu = fmu_dir / f"{name}.fmu"
    assert together[name] == course(plan_of(fmu, unpack(fmu, tmp_path)))


@pytest.mark.parametrize("name", sampled("filter"))
def test_one_documented_call_builds_the_binary(fmu_dir: Path, tmp_path: Path, name: str) -> None:
    fmu = fmu_dir / f"{name}.fmu"
    folder = unpack(fmu, tmp_path / "fmu")
    command = BUILD.format(name=name)
    assert command.replace("&", "&amp;") in (folder / "documentation/index.html").read_text()
    run(["sh", "-c", command], folder)
    theirs = course(plan_of(fmu, folder, folder / f"{name}.so"), 200)
    assert theirs == course(plan_of(fmu, folder), 200)


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("name", sampled("feedback"))
def test_cmake_builds_the_binary(fmu_dir: Path, tmp_path: Path, name: str, static: bool) -> None:
    if not shutil.which("cmake"):
        pytest.skip("CMake is not installed")
    fmu = fmu_dir / f"{name}.fmu"
    folder = unpack(fmu, tmp_path / "fmu")
    options = ["-DFLEXHEX_STATIC=ON"] if static else []
    run(["cmake", "-S", "sources", "-B", "build", *options], folder)
    run(["cmake", "--build", "build"], folder)
    if static:
        symbols = run(["nm", "--defined-only", "-g", f"build/lib{name}.a"], folder)
        assert f" T {name}_fmi2DoStep" in symbols
        return
    theirs = course(plan_of(fmu, folder, folder / "build" / f"{name}.so"), 200)
    assert theirs == course(plan_of(fmu, folder), 200)


@pytest.mark.parametrize("name", sampled("feedback"))
def test_fmpy_compiles_the_binary(fmu_dir: Path, tmp_path: Path, name: str) -> None:
    if not shutil.which("cmake"):
        pytest.skip("FMPy needs CMake")
    original, fmu = fmu_dir / f"{name}.fmu", tmp_path / f"{name}.fmu"
    with zipfile.ZipFile(original) as old, zipfile.ZipFile(fmu, "w") as new:
        for member in old.namelist():
            if not member.startswith("binaries/"):
                new.writestr(member, old.read(member))
    run([sys.executable, "-m", "fmpy", "compile", str(fmu)], tmp_path)
    assert f"binaries/linux64/{name}.so" in members(fmu), "FMPy compiled nothing"
    ours = course(plan_of(original, unpack(original, tmp_path / "ours")), 200)
    assert course(plan_of(fmu, unpack(fmu, tmp_path / "theirs")), 200) == ours


@pytest.mark.parametrize("name", NAMES)
def test_hand_written_files_give_no_warning(fmu_dir: Path, tmp_path: Path, name: str) -> None:
    folder = unpack(fmu_dir / f"{name}.fmu", tmp_path) / "sources"
    files = [p.name for p in sorted(folder.glob("*.c")) if not p.name.endswith("_casadi.c")]
    assert len(files) >= 9
    run([*compiler(), *STRICT, "-pedantic", "-fsyntax-only", *files], folder)
