"""The sources of every FMU compile without a warning: by gcc, clang and tcc, as C and as C++."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.conformity.test_sources import course, plan_of, unpack
from tests.conformity.test_strict_c import CASES, sources

WARNINGS = ("-Wall", "-Wextra", "-Wpedantic")
COMPILERS = {
    "gcc": ("gcc", "-std=c99", *WARNINGS),
    "clang": ("clang", "-std=c99", *WARNINGS),
    "tcc": ("tcc", "-Wall"),
    "g++": ("g++", "-x", "c++", "-std=c++11", *WARNINGS),
    "clang++": ("clang++", "-x", "c++", "-std=c++11", *WARNINGS),
}


def objections(compiler: str, folder: Path) -> str:
    """What a compiler says of the C files of a folder; it leaves their object files there."""
    command = COMPILERS[compiler]
    if not shutil.which(command[0]):
        pytest.skip(f"no {compiler} on the PATH")
    said = ""
    for source in sorted(folder.glob("*.c")):
        words = [*command, "-fPIC", "-c", source.name, "-o", f"{source.stem}.o"]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        said += done.stdout + done.stderr
    return said


@pytest.mark.sample(4)
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(("kind", "name"), CASES)
def test_compiler_has_no_objection(
    fmu_dir: Path, tmp_path: Path, kind: str, name: str, compiler: str
) -> None:
    folder = sources(kind, name, fmu_dir, tmp_path)
    (folder / "all.c").unlink()
    assert objections(compiler, folder) == ""


@pytest.mark.parametrize("compiler", COMPILERS)
def test_library_of_any_compiler_gives_the_same_outputs(
    fmu_dir: Path, tmp_path: Path, compiler: str
) -> None:
    """Without optimisation, and by compilers that contract no products and sums."""
    fmu = fmu_dir / "feedback.fmu"
    folder = unpack(fmu, tmp_path)
    assert objections(compiler, folder / "sources") == ""
    objects = map(str, sorted((folder / "sources").glob("*.o")))
    library = folder / "other.so"
    link = [COMPILERS[compiler][0], "-shared", *objects, "-lm", "-o", str(library)]
    subprocess.run(link, check=True)
    theirs = course(plan_of(fmu, folder, library), 200)
    assert theirs == course(plan_of(fmu, folder), 200)


def test_warning_is_seen(tmp_path: Path) -> None:
    (tmp_path / "x.c").write_text("int f(int unused);\nint f(int unused) { return 0; }\n")
    assert "unused" in objections("gcc", tmp_path)
