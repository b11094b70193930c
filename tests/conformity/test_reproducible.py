"""The same machine gives the same bytes: in another folder, process, language and umask."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flexhex.fmugen.rooms import ROOMS
from tests.conftest import MACHINE_FILE, ROOT

CODE = """
import os, sys
from pathlib import Path
os.umask({umask:#o})
from flexhex.fmugen.rooms import build_machine, build_room
from flexhex.fmus.common.machine_file import load_machine, real_file, truth_file
machine = load_machine(Path({machine!r}))
for room in {rooms!r}:
    build_room(room, machine, Path("fmus"), cache=Path("cache"))
if {truth!r}:
    file = Path({machine!r})
    real = load_machine(real_file(file))
    build_machine(real, truth_file(file), Path("fmus"), cache=Path("cache"))
"""


def build(folder: Path, rooms: tuple[str, ...], umask: int, language: str, seed: str) -> Path:
    """FMUs built from nothing in a process of its own, whose folder is `folder`."""
    folder.mkdir(parents=True)
    code = CODE.format(umask=umask, machine=str(MACHINE_FILE), rooms=rooms, truth=len(rooms) > 2)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "build")]),
        "PYTHONHASHSEED": seed,
        "LC_ALL": language,
        "LANG": language,
        "TZ": "Asia/Tokyo" if seed == "1" else "UTC",
    }
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return folder / "fmus"


@pytest.mark.parametrize(
    "rooms",
    [
        ("feedback",),
        pytest.param(
            ROOMS,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_archives_are_equal_byte_for_byte(tmp_path: Path, rooms: tuple[str, ...]) -> None:
    first = build(tmp_path / "one", rooms, 0o022, "C", "1")
    second = build(tmp_path / "some where" / "élse", rooms, 0o077, "C.UTF-8", "2")
    made = sorted(p.name for p in first.iterdir())
    assert made == sorted(p.name for p in second.iterdir())
    assert len(made) == len(rooms) + (len(rooms) > 2)
    for name in made:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name
