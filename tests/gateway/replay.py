"""The controller's FMUs by FMPy and the timing rule alone, on angles and torques from a recording.

At a base step n the components whose period divides n publish their outputs; then these components
take their inputs, and each steps from n to one period later. It shares no code with the executor.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from flexhex.ssp.read import Package, period, read_ssp
from tests.gateway.bench import Rows

HOST = "plant"
Bus = dict[str, float]


class Component:
    """One FMU; names on the bus are COMPONENT.VARIABLE."""

    def __init__(self, package: Package, name: str, folder: Path, more: dict[str, float]) -> None:
        instance = package.instance(name)
        file = folder / f"{name}.fmu"
        file.write_bytes(package.fmus[instance.source])
        described = read_model_description(str(file))
        self.period, self.base = period(instance, package.base), package.base
        wires = [wire for wire in package.wires if wire.target == name]
        reference = {v.name: v.valueReference for v in described.modelVariables}
        kinds = {v.name: v.type for v in described.modelVariables}
        outputs = [v.name for v in described.modelVariables if v.causality == "output"]
        self.fmu = FMU2Slave(
            guid=described.guid,
            unzipDirectory=extract(str(file), str(folder / name)),
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        for parameter, value in (instance.parameters | more).items():
            if parameter not in reference:
                continue
            if kinds[parameter] == "Real":
                self.fmu.setReal([reference[parameter]], [value])
            elif kinds[parameter] == "Boolean":
                self.fmu.setBoolean([reference[parameter]], [int(value)])
            else:
                self.fmu.setInteger([reference[parameter]], [int(value)])
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.inputs = [(f"{w.source}.{w.output}", reference[w.input]) for w in wires]
        real = [v for v in outputs if kinds[v] == "Real"]
        self.outputs = [(f"{name}.{v}", reference[v]) for v in real]
        assert all(kinds[w.input] == "Real" for w in wires)

    def publish(self, bus: Bus) -> None:
        """Outputs to the bus."""
        values = self.fmu.getReal([reference for _, reference in self.outputs])
        bus.update(zip((name for name, _ in self.outputs), values, strict=True))

    def step(self, bus: Bus, n: int) -> None:
        """Inputs from the bus, and one step."""
        references = [reference for _, reference in self.inputs]
        self.fmu.setReal(references, [bus[name] for name, _ in self.inputs])
        self.fmu.doStep(n * self.base, self.period * self.base)


def replayed(
    ssp: Path, folder: Path, more: dict[str, dict[str, float]], theta: Rows, tau_meas: Rows
) -> Iterator[Bus]:
    """What is on the bus at n = 0, 1, ..., with angles and measured torques (n, 6).

    more: parameters of components, as {"feedback": {"tau_step": 0.003}}.
    """
    package = read_ssp(ssp)
    names = [instance.name for instance in package.instances if instance.name != HOST]
    parts = [Component(package, name, folder, more.get(name, {})) for name in names]
    bus: Bus = {}
    for n, (angles, torques) in enumerate(zip(theta, tau_meas, strict=True)):
        due = [part for part in parts if n % part.period == 0]
        for part in due:
            part.publish(bus)
        for k in range(6):
            bus[f"{HOST}.theta[{k + 1}]"] = float(angles[k])
            bus[f"{HOST}.tau_meas[{k + 1}]"] = float(torques[k])
        yield bus
        for part in due:
            part.step(bus, n)
