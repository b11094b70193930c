"""The cache of FMUs: a hit only when nothing changed, damage repaired, size bounded."""

from __future__ import annotations

import ctypes
import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from flexhex.fmugen import blocks, cache, compile, fmu, sources
from flexhex.fmugen.blocks import Source
from flexhex.fmus.common.machine.machine import Machine
from flexhex.numeric import library
from flexhex.numeric.library import loaded
from flexhex.numeric.rows import RowFunction, native
from tests.conftest import MACHINE_FILE, ROOT

BLOCK = "feedback"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What was done: `equations` derived, C files compiled, an `fmu` packed."""
    done: list[str] = []
    functions, build, run = Source.functions, blocks.build_fmu, compile._run

    def watched_run(command: list[str], folder: Path | None = None) -> str:
        done.extend(word for word in command if word.endswith(".c"))
        return run(command, folder)

    def watched_functions(source: Source) -> object:
        done.append("equations")
        return functions(source)

    def watched_build(*arguments: object) -> Path:
        done.append("fmu")
        return build(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(compile, "_run", watched_run)
    monkeypatch.setattr(Source, "functions", watched_functions)
    monkeypatch.setattr(blocks, "build_fmu", watched_build)
    return done


def test_same_machine_is_built_once_and_equals_a_fresh_build(
    folder: Path, work: list[str], machine: Machine, tmp_path: Path
) -> None:
    first = Source(BLOCK, machine).build_kept(tmp_path / "a").read_bytes()
    assert {"equations", "fmu", f"{BLOCK}_step.c"} <= set(work)
    work.clear()
    assert Source(BLOCK, machine).build_kept(tmp_path / "b").read_bytes() == first
    assert work == []
    assert Source(BLOCK, machine).build(tmp_path / "c").read_bytes() == first


def test_other_start_values_compile_one_table(
    folder: Path, work: list[str], machine: Machine, tmp_path: Path
) -> None:
    first = Source(BLOCK, machine).build_kept(tmp_path / "a").read_bytes()
    work.clear()
    starts = {"reference_delay": 7.0}
    other = Source(BLOCK, machine).build_kept(tmp_path / "b", starts).read_bytes()
    assert work == ["fmu", f"{BLOCK}_fmu.c"]
    assert other != first
    assert Source(BLOCK, machine).build(tmp_path / "c", starts).read_bytes() == other


def test_whatever_determines_an_fmu_makes_another_key(
    folder: Path, machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    keys = [Source(BLOCK, machine)._key()]
    heavier = machine.model_copy(update={"name": "other"})
    keys.append(Source(BLOCK, heavier)._key())
    keys.append(Source("filter", machine)._key())
    truth = MACHINE_FILE.with_name("tflex-truth.toml")
    keys.append(Source(BLOCK, machine, truth)._key())
    changed = tmp_path / "x-truth.toml"
    changed.write_text(truth.read_text(encoding="utf-8").replace("seed = ", "seed = 1"))
    keys.append(Source(BLOCK, machine, changed)._key())
    monkeypatch.setattr(blocks, "versions", lambda: (("casadi", "0"),))
    keys.append(Source(BLOCK, machine)._key())
    monkeypatch.setattr(cache, "sources", lambda: "other sources")
    keys.append(Source(BLOCK, machine)._key())
    assert len(set(keys)) == len(keys)


def test_compiler_and_its_flags_make_another_fmu(
    folder: Path, work: list[str], machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Source(BLOCK, machine).build_kept(tmp_path / "a")
    own = blocks.tool(blocks.host())
    for other in (
        dataclasses.replace(own, version="gcc 99"),
        dataclasses.replace(own, flags=(*own.flags, "-g0")),
    ):
        work.clear()
        monkeypatch.setattr(blocks, "tool", lambda name, other=other: other)
        Source(BLOCK, machine).build_kept(tmp_path / "b")
        assert "fmu" in work
        assert "equations" not in work, "the C is the same"


def test_sources_are_hashed_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "flexhex"
    for part in ("fmus/plant", "fmugen", "runtime"):
        (package / part).mkdir(parents=True)
    (package / "fmus" / "plant" / "step.c").write_text("int x;")
    monkeypatch.setattr(cache, "__file__", str(package / "fmugen" / "cache.py"))
    digest = cache.sources.__wrapped__
    digests = [digest()]
    (package / "fmus" / "plant" / "step.c").write_text("int y;")
    digests.append(digest())
    (package / "fmus" / "plant" / "effects.h").write_text("")
    digests.append(digest())
    (package / "fmus" / "plant" / "effects.h").rename(package / "runtime" / "effects.h")
    digests.append(digest())
    assert len(set(digests)) == 4


def test_damaged_files_are_made_anew(folder: Path, machine: Machine, tmp_path: Path) -> None:
    first = Source(BLOCK, machine).build_kept(tmp_path / "a").read_bytes()
    for kind in ("fmus", "equations"):
        for path in (folder / kind).iterdir():
            data = path.read_bytes()
            path.write_bytes(data[:-10] + b"0123456789")
    for path in (folder / "objects").iterdir():
        path.write_bytes(path.read_bytes()[:40])
    assert Source(BLOCK, machine).build_kept(tmp_path / "b").read_bytes() == first
    (whole,) = (folder / "fmus").iterdir()
    whole.write_bytes(b"")
    assert Source(BLOCK, machine).build_kept(tmp_path / "c").read_bytes() == first


def test_a_cache_that_cannot_be_written_is_not_used(
    machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "file" / "cache"))
    assert Source(BLOCK, machine).build_kept(tmp_path / "a").is_file()
    assert (tmp_path / "a" / "cache").is_dir(), "objects are beside the FMU"


BUILD = """
from pathlib import Path
from flexhex.fmugen.blocks import Source
from flexhex.fmus.common.machine_file import load_machine
Source({block!r}, load_machine({machine!r})).build_kept(Path({out!r}))
"""


def test_two_processes_build_side_by_side(folder: Path, machine: Machine, tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    running = []
    for name in ("one", "two"):
        code = BUILD.format(block=BLOCK, machine=str(MACHINE_FILE), out=str(tmp_path / name))
        running.append(subprocess.Popen([sys.executable, "-c", code], env=environment))
    assert [process.wait() for process in running] == [0, 0]
    written = [(tmp_path / name / f"{BLOCK}.fmu").read_bytes() for name in ("one", "two")]
    assert written[0] == written[1] == Source(BLOCK, machine).build(tmp_path / "c").read_bytes()
    kept = [path for path in folder.rglob("*") if path.is_file()]
    assert [path for path in kept if path.name.startswith(".")] == [], "nothing half-written"


def test_least_recently_used_files_go_first(folder: Path) -> None:
    paths = []
    for age, name in ((5e4, "old"), (4e4, "used again"), (3e4, "young"), (10.0, "in use")):
        path = folder / "fmus" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        cache._write(path, b"x" * 1000)
        used = path.stat().st_mtime - age
        os.utime(path, (used, used))
        paths.append(path)
    assert cache.kept("fmus", "used again", lambda: b"") == b"x" * 1000
    cache.trim(folder, limit=3 * 1032)
    assert [path.name for path in paths if path.exists()] == ["used again", "young", "in use"]
    cache.trim(folder, limit=0)
    assert [path.name for path in paths if path.exists()] == ["used again", "in use"]
    cache.trim(folder, limit=0, in_use=-1e9)
    assert not any(path.exists() for path in paths)


def test_folder_follows_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    assert cache.root() == tmp_path
    monkeypatch.delenv(cache.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", "/x")
    assert cache.root() == Path("/x/flexhex")
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache.root() == tmp_path / ".cache" / "flexhex"


def test_generated_c_survives_its_file(machine: Machine) -> None:
    source = Source(BLOCK, machine)
    generated = sources.Generated.of(source.interface(), source.functions(), BLOCK)
    assert sources.Generated.loaded(generated.dumped()) == generated
    assert generated.source
    assert fmu.RUNTIME.is_dir()


def test_library_of_equations_is_compiled_once_for_all_working_folders(
    folder: Path, work: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a", "b"):
        place = tmp_path / name
        place.mkdir()
        monkeypatch.chdir(place)
        library = loaded("double one(void) { return 1.0; }\n", "one")
        library.one.restype = ctypes.c_double
        assert library.one() == 1.0
        assert list(place.iterdir()) == []
    assert work == ["one.c"]
    assert len(list(folder.glob("objects/one-*.so"))) == 1


def scaled(factor: float) -> RowFunction:
    """factor x, compiled for NumPy."""
    x = ca.SX.sym("x", 1)
    return native([ca.Function("native_scaled", [x], [factor * x])])[0]


def test_c_of_a_function_is_written_once_and_anew_for_another(
    folder: Path, work: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write = library.casadi_source

    def watched(functions: list[ca.Function], block: str, identifier: str) -> str:
        work.append("written")
        return write(functions, block, identifier)

    monkeypatch.setattr(library, "casadi_source", watched)
    for factor in (3.0, 3.0, 4.0):
        assert scaled(factor)(np.ones((2, 1)))[0].tolist() == [[factor], [factor]]
    assert work == 2 * ["written", "native.c"]
    monkeypatch.setattr(cache, "sources", lambda: "another generator")
    scaled(3.0)
    assert work[4:] == ["written"], "the same C is not compiled again"
