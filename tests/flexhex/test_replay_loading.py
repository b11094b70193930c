"""Replays side by side load their FMUs one after the other: fmpy changes the working directory."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier, BrokenBarrierError
from types import SimpleNamespace
from typing import Any

import pytest

from flexhex.diagnose import replay


def test_relative_path_holds_while_another_replay_loads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stand-in for fmpy that waits within the other directory for the other thread to come."""
    monkeypatch.chdir(tmp_path)
    Path("elsewhere").mkdir()
    for name in "ab":
        Path(f"{name}.fmu").touch()
    both = Barrier(2)

    def loaded(**given: Any) -> str:
        home = Path.cwd()
        os.chdir("elsewhere")
        try:
            both.wait(0.2)
        except BrokenBarrierError:
            pass  # nobody else is here
        finally:
            os.chdir(home)
        return str(given["unzipDirectory"])

    def extracted(fmu: str) -> str:
        assert Path(fmu).exists(), f"{fmu} was looked for in {Path.cwd()}"
        return fmu

    described = SimpleNamespace(guid="", coSimulation=SimpleNamespace(modelIdentifier="plant"))
    stub = {"read_model_description": lambda *_, **__: described, "extract": extracted}
    monkeypatch.setattr(replay, "fmpy", SimpleNamespace(**stub))
    monkeypatch.setattr(replay, "FMU2Slave", loaded)
    with ThreadPoolExecutor(2) as pool:
        loads = list(pool.map(replay._loaded, [Path("a.fmu"), Path("b.fmu")]))
    assert [folder for _, folder, _ in loads] == ["a.fmu", "b.fmu"]
    assert Path.cwd() == tmp_path
