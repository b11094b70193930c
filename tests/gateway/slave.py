"""One FMU by FMPy, outside of any executor."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


class Slave:
    """An instance that has left its initialisation."""

    def __init__(
        self, fmu: Path, folder: Path, name: str, parameters: Mapping[str, float] | None = None
    ) -> None:
        described = read_model_description(str(fmu))
        self.references = {v.name: v.valueReference for v in described.modelVariables}
        self.fmu = FMU2Slave(
            guid=described.guid,
            unzipDirectory=extract(str(fmu), str(folder)),
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.set(parameters or {})
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, values: Mapping[str, float]) -> None:
        """Values of variables by name."""
        self.fmu.setReal([self.references[name] for name in values], list(values.values()))

    def get(self, names: list[str]) -> list[float]:
        """Values of variables by name."""
        return list(self.fmu.getReal([self.references[name] for name in names]))
