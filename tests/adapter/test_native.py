"""The adapter without an importer: two FMUs linked into one C program."""

from __future__ import annotations

import ctypes as ct
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from flexhex.fmugen.compile import compiler
from tests.adapter import toys
from tests.adapter.slave import Binary, Slave
from tests.adapter.toys import BASE, VR
from tests.conftest import OBJECTS

HARNESS = Path(__file__).parent / "harness.c"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror")


@pytest.fixture(scope="module")
def pair(toy: Binary, tmp_path_factory: pytest.TempPathFactory) -> tuple[Binary, Binary]:
    """toy and toy_two, unpacked."""
    folder = tmp_path_factory.mktemp("two")
    return toy, Binary(toys.build(folder, OBJECTS, name="toy_two", period=3), folder / "unpacked")


def run(command: Sequence[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return done.stdout


def link(pair: tuple[Binary, Binary], folder: Path, flags: Sequence[str] = ()) -> dict[str, float]:
    """Compile both FMUs from their own sources into one program with harness.c and run it."""
    objects = []
    for binary in pair:
        own = folder / binary.name
        own.mkdir()
        sources = sorted(str(p) for p in (binary.folder / "sources").glob("*.c"))
        run([*compiler(), "-std=c99", "-O2", *flags, "-DFLEXHEX_STATIC", "-c", *sources], own)
        objects += [str(p) for p in sorted(own.glob("*.o"))]
    headers = f"-I{pair[0].folder / 'sources'}"
    main = [*compiler(), *STRICT, "-O2", *flags, headers, str(HARNESS)]
    # no builtin: the compiler must not take the harness's calloc for the library's
    run([*main, "-fno-builtin", *objects, "-lm", "-o", "program"], folder)
    lines = run(["./program", pair[0].guid, pair[1].guid], folder).split()
    return {name: float(value) for name, value in zip(lines[::2], lines[1::2], strict=True)}


@pytest.fixture(scope="module")
def figures(
    pair: tuple[Binary, Binary], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, float]:
    """What the program prints."""
    return link(pair, tmp_path_factory.mktemp("static"))


def test_two_fmus_link_and_run_in_one_program(figures: dict[str, float]) -> None:
    assert figures["bad"] == 0
    assert figures["refusals"] > 80


def test_instance_is_one_allocation(figures: dict[str, float]) -> None:
    assert figures["at_instantiate"] == 1


def test_nothing_is_allocated_from_initialisation_on(figures: dict[str, float]) -> None:
    """Initialisation, 20 000 steps, and refused values with their messages."""
    assert figures["in_steps"] == 0


def test_idle_step_with_100_values_each_way_is_fast(figures: dict[str, float]) -> None:
    # about 0.3 us on a 2020s core; ten times that still leaves 98 % of a base step
    assert figures["idle_ns"] < 3000


def test_sanitizers_find_nothing(pair: tuple[Binary, Binary], tmp_path: Path) -> None:
    flags = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    probe = tmp_path / "probe.c"
    probe.write_text("int main(void) { return 0; }\n")
    command = [*compiler(), *flags, str(probe), "-o", str(tmp_path / "probe")]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("the compiler has no sanitizers")
    assert link(pair, tmp_path, (*flags, "-DHARNESS_SANITIZED"))["bad"] == 0


def test_sources_build_with_one_compiler_call(toy: Binary, tmp_path: Path) -> None:
    sources = sorted(str(p) for p in (toy.folder / "sources").glob("*.c"))
    target = tmp_path / "toy.so"
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC"]
    run([*compiler(), *flags, *sources, "-lm", "-o", str(target)], tmp_path)
    ours = Slave(toy).initialise()
    binary = Binary.__new__(Binary)
    binary.__dict__.update(toy.__dict__)
    binary.library = ct.CDLL(str(target))
    binary.library.fmi2Instantiate.restype = ct.c_void_p
    theirs = Slave(binary).initialise()
    for slave in (ours, theirs):
        slave.set([VR["u"]], [0.123])
        slave.advance(40, BASE)
    assert ours.serialised() == theirs.serialised()
    ours.free()
    theirs.free()


def test_shared_library_exports_fmi_only(toy: Binary) -> None:
    library = toy.folder / "binaries" / "linux64" / "toy.so"
    symbols = run(["nm", "-D", "--defined-only", str(library)], toy.folder).split()[2::3]
    assert symbols
    assert all(symbol.startswith("fmi2") for symbol in symbols)
    assert run(["nm", str(library)], toy.folder) == "", "not stripped"


def test_static_symbols_wear_the_identifier(pair: tuple[Binary, Binary], tmp_path: Path) -> None:
    sources = sorted(str(p) for p in (pair[1].folder / "sources").glob("*.c"))
    run([*compiler(), "-std=c99", "-DFLEXHEX_STATIC", "-c", *sources], tmp_path)
    objects = sorted(str(p) for p in tmp_path.glob("*.o"))
    lines = run(["nm", "--defined-only", "-g", *objects], tmp_path).splitlines()
    symbols = [line.split()[2] for line in lines if len(line.split()) == 3]
    assert len(symbols) > 40
    assert [s for s in symbols if not s.startswith("toy_two_")] == []
