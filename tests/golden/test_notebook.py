"""The notebook of examples/robot does what it shows: `make golden` keeps its outputs anew."""

from __future__ import annotations

import base64
import importlib
import json
import re
import shutil
import sys
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.compare import assert_close
from tests.conftest import ROOT
from tests.golden import notebook
from tests.test_files import private_places

FOLDER = ROOT / "examples" / "robot"
FILE = FOLDER / "robot.ipynb"
LARGEST, LOGS = 400_000, 300_000
"""Bytes of the notebook, of its logs together."""


def test_cells_show_what_the_notebook_shows(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    monkeypatch.setenv("MPLBACKEND", "agg")
    for path in FOLDER.iterdir():
        if path.suffix in (".csv", ".urdf", ".py"):
            shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "make_logs", raising=False)
    kept, names = notebook.read(FILE), dict[str, Any](__name__="__main__")
    done = deepcopy(kept)
    for cell in notebook.code_cells(done):
        cell["outputs"] = notebook.run(cell, names)
    if request.config.getoption("--update"):
        notebook.write(FILE, done)
        return
    pairs = zip(notebook.code_cells(done), notebook.code_cells(kept), strict=True)
    for mine, theirs in pairs:
        said, shown = (notebook.texts(cell["outputs"]) for cell in (mine, theirs))
        assert len(said) == len(shown), f"cell {mine['id']}: `make golden` if that is wanted"
        for text, other in zip(said, shown, strict=True):
            wrong = notebook.difference(text, other)
            assert not wrong, f"cell {mine['id']}: {wrong}: `make golden` if that is wanted"


def test_notebook_is_small_and_says_nothing_of_a_computer() -> None:
    assert FILE.stat().st_size < LARGEST
    assert sum(path.stat().st_size for path in FOLDER.glob("*.csv")) < LOGS
    kept = notebook.read(FILE)
    assert private_places(json.dumps(kept)) == []
    assert "/tmp" not in json.dumps(kept)
    for cell in notebook.code_cells(kept):
        assert cell["execution_count"] is None
        assert cell["metadata"] == {}
    outputs = [out for cell in notebook.code_cells(kept) for out in cell["outputs"]]
    assert not [
        out for out in outputs if out["output_type"] == "error" or out.get("name") == "stderr"
    ]
    pictures = [out["data"]["image/png"] for out in outputs if "image/png" in out.get("data", {})]
    assert len(pictures) == 4
    assert all(base64.b64decode(one).startswith(b"\x89PNG") for one in pictures)


def test_a_log_is_what_the_script_writes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another MuJoCo may sum in another order: a few steps of the last digits."""
    monkeypatch.syspath_prepend(str(FOLDER))
    monkeypatch.delitem(sys.modules, "make_logs", raising=False)
    made = importlib.import_module("make_logs").log("c", 1).splitlines()
    kept = (FOLDER / "c1.csv").read_text(encoding="utf-8").splitlines()
    assert made[:4] == kept[:4]
    ours, theirs = (np.loadtxt(lines, delimiter=",", skiprows=4) for lines in (made, kept))
    assert_close(ours[:, :4], theirs[:, :4], atol=5e-6)
    assert_close(ours[:, 4:], theirs[:, 4:], atol=2e-2)


def test_every_value_that_was_hidden_lies_in_its_interval() -> None:
    """As the notebook's last cell shows it."""
    last = "".join(notebook.texts(notebook.code_cells(notebook.read(FILE))[-1]["outputs"]))
    lines = re.findall(r"(\S+) +([\d.]+)  (in|outside) +([-\d.]+) to ([-\d.]+)", last)
    assert len(lines) == 10
    for name, true, where, low, high in lines:
        assert where == "in", name
        assert float(low) <= float(true) <= float(high), name


@pytest.mark.parametrize(
    ("text", "other", "same"),
    [
        ("a = 1.25 N m", "a = 1.26 N m", True),
        ("a = 1.25 N m", "a = 1.55 N m", False),
        ("a = 1.25 N m", "b = 1.25 N m", False),
        ("F_c[1] 0.8", "F_c[2] 0.8", False),
        ("left 16 %", "left 55 %", False),
        ("± 0.004", "±  0.005", True),
        ("Yes. Confidence 88 %, as 1 of 2 such answers in the study were right (Laplace's rule).",
         "Yes.", True),
        ("two", "two words", False),
    ],
)  # fmt: skip
def test_differences_are_seen(text: str, other: str, same: bool) -> None:
    assert (notebook.difference(text, other) == "") == same


def test_outputs_are_those_of_jupyter() -> None:
    cell = {"id": "x", "source": ["print('a')\n", "b = 2\n", "b + 1"]}
    assert notebook.run(cell, {}) == [
        {"name": "stdout", "output_type": "stream", "text": ["a\n"]},
        {"data": {"text/plain": ["3"]}, "execution_count": None, "metadata": {},
         "output_type": "execute_result"},
    ]  # fmt: skip
