"""Published figures stand beside the machine that they were published of, and no other."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import MachineError
from flexhex.run.outcome import Rows, figure_rows
from flexhex.simulation.metrics import KEYS
from flexhex.simulation.provenance import sentence, sources
from flexhex.simulation.published import published, published_file, published_row
from tests.conftest import MACHINE_FILE


def test_copy_of_the_machine_file_has_no_published_figures(tmp_path: Path) -> None:
    mine = Path(shutil.copyfile(MACHINE_FILE, tmp_path / "my.toml"))
    assert published(mine) is None
    assert figure_rows(Rows((), published(mine))) == []
    known = published(MACHINE_FILE)
    assert known
    assert known.rows["adaptive"][:2] == (31.8, 0.0117)
    assert "predicts nothing" in known.caveat


def test_shorter_row_leaves_the_other_columns_empty() -> None:
    alone = published(MACHINE_FILE.with_name("tflex-actuators.toml"))
    assert alone
    row = published_row(alone.rows["fixed"])
    assert (row["e"], row["tau_fb"]) == (34.6, 0.0131)
    assert all(row[key] is None for key in KEYS[2:])


def test_bad_file_names_file_and_field(tmp_path: Path) -> None:
    path = published_file(tmp_path / "my.toml")
    path.write_text('source = "a"\n[rows]\nfixed = ["many"]\n', encoding="utf-8")
    with pytest.raises(MachineError, match=r"my-published\.toml: rows\.fixed\.1: "):
        published(tmp_path / "my.toml")


def test_sources_of_the_machine_file_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(
        """name = "a"
        m = { value = 1.0, unit = "kg", source = "assumed", note = "weight; tuned" }
        [[arms]]
        x = { value = [1.0, 2.0], unit = "m", source = "published" }
        y = { value = 1.0, unit = "m", source = "assumed", note = "untuned" }
        """,
        encoding="utf-8",
    )
    assert sources(path) == {"published": 1, "assumed": 2, "tuned": 1}
    assert sentence(path) == "Quantities in a.toml: 1 published, 2 assumed (1 of them tuned)."
