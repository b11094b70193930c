"""The same machine gives the same bytes: in another folder, process, language and umask."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flexhex.fmugen.blocks import BLOCKS
from tests.conftest import MACHINE_FILE, ROOT

CODE = """
import os, sys
from pathlib import Path
os.umask({umask:#o})
from flexhex.fmugen.blocks import build_machine, build_block
from flexhex.fmus.common.machine_file import load_machine, real_file, truth_file
machine = load_machine(Path({machine!r}))
for block in {blocks!r}:
    build_block(block, machine, Path("fmus"), cache=Path("cache"))
if {truth!r}:
    file = Path({machine!r})
    real = load_machine(real_file(file))
    build_machine(real, truth_file(file), Path("fmus"), cache=Path("cache"))
"""


def build(folder: Path, blocks: tuple[str, ...], umask: int, language: str, seed: str) -> Path:
    """FMUs built from nothing in a process of its own, whose folder is `folder`."""
    folder.mkdir(parents=True)
    code = CODE.format(umask=umask, machine=str(MACHINE_FILE), blocks=blocks, truth=len(blocks) > 2)
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
    "blocks",
    [
        ("feedback",),
        pytest.param(
            BLOCKS,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_archives_are_equal_byte_for_byte(tmp_path: Path, blocks: tuple[str, ...]) -> None:
    first = build(tmp_path / "one", blocks, 0o022, "C", "1")
    second = build(tmp_path / "some where" / "élse", blocks, 0o077, "C.UTF-8", "2")
    names = sorted(p.name for p in first.iterdir())
    assert names == sorted(p.name for p in second.iterdir())
    assert len(names) == len(blocks) + (len(blocks) > 2)
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name
