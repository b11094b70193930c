"""Golden results: what an FMU answered to recorded inputs, as short CSV files.

    tests/golden/<fmu>.in.csv    one row for each Ts: the inputs before the step
    tests/golden/<fmu>.out.csv   the outputs after it

`make golden` records both anew: inputs from the running adaptive loop, outputs from the FMU.
"""

from __future__ import annotations

import csv
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

from tests.typed import outputs_of, values_of

FOLDER = Path(__file__).resolve().parent
Table = tuple[list[str], NDArray[np.float64]]


def read(path: Path) -> Table:
    """Names and rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    names = rows[0] if rows else []
    return names, np.array(rows[1:], dtype=float).reshape(len(rows) - 1, len(names))


def write(path: Path, names: list[str], rows: NDArray[np.float64]) -> None:
    """Names, then rows with as many digits as read back exactly."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([repr(float(v)) for v in row] for row in rows)


def play(fmu: Path, names: list[str], rows: NDArray[np.float64], repeats: int) -> Table:
    """Feed rows of inputs, each held for `repeats` Ts, to a fresh instance; outputs after each."""
    description = fmpy.read_model_description(str(fmu))
    variables = {v.name: v for v in description.modelVariables}
    outputs = outputs_of(description)
    Ts = float(variables["Ts"].start)
    with tempfile.TemporaryDirectory() as folder:
        fmpy.extract(str(fmu), folder)
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="golden",
        )
        slave.instantiate()
        slave.setupExperiment()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        answers = []
        for k, row in enumerate(rows):
            slave.setReal([variables[name].valueReference for name in names], list(row))
            slave.doStep(k * repeats * Ts, repeats * Ts)
            answers.append(values_of(slave, outputs))
        slave.terminate()
        slave.freeInstance()
    return [v.name for v in outputs], np.array(answers)
