"""The adaptive loop stepped instance by instance through ctypes, so that states can be taken."""

from __future__ import annotations

import ctypes as ct
import zipfile
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from flexhex.check.binary import SUFFIXES, make_plan
from flexhex.check.slave import Instance, Place
from flexhex.check.subject import Subject
from flexhex.ssp.fmu import FmuVariable
from flexhex.ssp.read import Package, read_ssp

Outputs = dict[str, list[float]]


@dataclass
class Loop:
    """All instances of a .ssp at one time; every base step they exchange their outputs (Jacobi)."""

    package: Package
    instances: dict[str, Instance]
    n: int = 0
    now: Outputs = field(default_factory=dict)

    @cached_property
    def outputs(self) -> dict[str, list[Place]]:
        """Places of the outputs by instance."""
        return {i.name: [place(v) for v in i.fmu.of("output")] for i in self.package.instances}

    @cached_property
    def inputs(self) -> dict[str, list[tuple[Place, str, int]]]:
        """By instance: place of each connected input, the source and which of its outputs."""
        inputs: dict[str, list[tuple[Place, str, int]]] = {name: [] for name in self.instances}
        for wire in self.package.wires:
            source = self.package.instance(wire.source).fmu.variables[wire.output]
            target = self.package.instance(wire.target).fmu.variables[wire.input]
            which = self.outputs[wire.source].index(place(source))
            inputs[wire.target].append((place(target), wire.source, which))
        return inputs

    def read(self) -> Outputs:
        """All outputs of all instances."""
        outputs: Outputs = {}
        for name, references in self.outputs.items():
            values = self.instances[name].get(references)
            assert values is not None
            outputs[name] = values
        return outputs

    def step(self) -> None:
        """One base step of all."""
        self.now = self.now or self.read()
        for name, wires in self.inputs.items():
            values = [self.now[source][which] for _, source, which in wires]
            slave = self.instances[name]
            assert slave.set([where for where, _, _ in wires], values), slave.last
            assert slave.step(self.n * self.package.base, self.package.base), slave.last
        self.n += 1
        self.now = self.read()

    def states(self) -> dict[str, bytes]:
        """Serialised states of all instances."""
        return {name: serialised(slave) for name, slave in self.instances.items()}

    def free(self) -> None:
        """Give all instances back."""
        for slave in self.instances.values():
            slave.free()


def place(variable: FmuVariable) -> Place:
    """FMI's function for a variable and its value reference."""
    return SUFFIXES[variable.type], variable.reference


def open_loop(path: Path, folder: Path, starts: dict[str, dict[str, float]]) -> Loop:
    """The .ssp's instances, initialised; starts: other parameter values, by instance and name."""
    package, instances = read_ssp(path), {}
    for instance in package.instances:
        fmu = folder / Path(instance.source).name
        inside = folder / fmu.stem
        if not fmu.exists():
            fmu.write_bytes(package.fmus[instance.source])
            with zipfile.ZipFile(fmu) as archive:
                archive.extractall(inside)
        plan = make_plan(Subject.open(fmu), inside, f"binaries/linux64/{instance.fmu.model}.so")
        slave = Instance(ct.CDLL(plan["library"]), plan)
        values = {**instance.parameters, **starts.get(instance.name, {})}
        places = [place(instance.fmu.variables[name]) for name in values]
        assert slave.set(places, list(values.values())), slave.last
        assert slave.initialise(), slave.last
        instances[instance.name] = slave
    return Loop(package, instances)


def serialised(slave: Instance) -> bytes:
    """The state of an instance as bytes."""
    state, size = ct.c_void_p(), ct.c_size_t()
    assert slave.call("fmi2GetFMUstate", ct.byref(state)) == 0
    assert slave.call("fmi2SerializedFMUstateSize", state, ct.byref(size)) == 0
    data = (ct.c_char * size.value)()
    assert slave.call("fmi2SerializeFMUstate", state, data, size) == 0
    assert slave.call("fmi2FreeFMUstate", ct.byref(state)) == 0
    return bytes(data)


def restore(slave: Instance, data: bytes) -> None:
    """Bring an instance to a serialised state."""
    state = ct.c_void_p()
    buffer = (ct.c_char * len(data)).from_buffer_copy(data)
    assert (
        slave.call("fmi2DeSerializeFMUstate", buffer, ct.c_size_t(len(data)), ct.byref(state)) == 0
    )
    assert slave.call("fmi2SetFMUstate", state) == 0
    assert slave.call("fmi2FreeFMUstate", ct.byref(state)) == 0
