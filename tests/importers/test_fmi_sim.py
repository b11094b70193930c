"""Single FMUs in fmi-sim (Rust, `cargo install fmi-sim`), against the results shipped with them."""

from __future__ import annotations

import csv
import io
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmugen.recorded import IN, OUT

Array = NDArray[np.float64]
NAMES = (*BLOCKS, "machine")
EARLY = 1e-6
"""fmi-sim 0.7.0 takes a row of inputs from the step after its time on; rows come this early [s]."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("fmi-sim") is None, reason="fmi-sim is not installed"),
]


def table(text: str) -> tuple[list[str], Array]:
    """Names and values of a CSV."""
    names, *rows = csv.reader(io.StringIO(text))
    return names, np.array(rows, dtype=float)


def simulated(fmu: Path, inputs: str, step: float, stop: float, folder: Path) -> str:
    """What fmi-sim writes for an FMU."""
    words = ["fmi-sim", "--model", str(fmu), "-o", str(folder / "out.csv")]
    if inputs:
        (folder / "in.csv").write_text(inputs)
        words += ["-i", str(folder / "in.csv")]
    words += ["co-simulation", "--step", repr(step), "--output-interval", repr(step)]
    subprocess.run([*words, "-f", repr(stop)], check=True, capture_output=True)
    return (folder / "out.csv").read_text()


def early(text: str) -> str:
    """The inputs with all rows but the first a little earlier."""
    head, first, *rows = text.splitlines()
    moved = [row.partition(",") for row in rows]
    return "\n".join(
        [head, first, *(f"{float(t) - EARLY!r}{comma}{v}" for t, comma, v in moved), ""]
    )


@pytest.mark.parametrize("block", NAMES)
def test_fmi_sim_gives_the_shipped_results(block: str, fmu_dir: Path, tmp_path: Path) -> None:
    fmu = fmu_dir / f"{block}.fmu"
    with zipfile.ZipFile(fmu) as archive:
        shipped = archive.read(OUT).decode()
        inputs = early(archive.read(IN).decode()) if IN in archive.namelist() else ""
    names, wanted = table(shipped)
    step = float(wanted[1, 0] - wanted[0, 0])
    header, rows = table(simulated(fmu, inputs, step, float(wanted[-1, 0]), tmp_path))
    assert header == names
    at = np.round(wanted[:, 0] / step).astype(int)
    assert np.abs(np.ptp(wanted[:, 1:], axis=0)).max() > 0, "the case must move something"
    assert np.array_equal(rows[at, 1:], wanted[:, 1:])
