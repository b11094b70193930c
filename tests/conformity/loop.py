"""The adaptive loop stepped instance by instance through ctypes, so that states can be taken."""

from __future__ import annotations

import ctypes as ct
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

from flexhex.check.binary import make_plan
from flexhex.check.slave import Instance
from flexhex.check.subject import Subject
from flexhex.ssp.read import Package, read_ssp

Outputs = dict[str, list[float]]


@dataclass
class Loop:
    """All instances of a .ssp at one time; every base step they exchange their outputs (Jacobi)."""

    package: Package
    instances: dict[str, Instance]
    n: int = 0
    now: Outputs = field(default_factory=dict)

    def read(self) -> Outputs:
        """All outputs of all instances."""
        found: Outputs = {}
        for instance in self.package.instances:
            references = [v.reference for v in instance.fmu.of("output")]
            values = self.instances[instance.name].get(references)
            assert values is not None
            found[instance.name] = values
        return found

    def step(self) -> None:
        """One base step of all."""
        self.now = self.now or self.read()
        for instance in self.package.instances:
            wires = [w for w in self.package.wires if w.target == instance.name]
            values = [self.now[w.source][self.place(w.source, w.output)] for w in wires]
            references = [instance.fmu.variables[w.input].reference for w in wires]
            slave = self.instances[instance.name]
            assert slave.set(references, values), slave.last
            assert slave.step(self.n * self.package.base, self.package.base), slave.last
        self.n += 1
        self.now = self.read()

    def place(self, source: str, output: str) -> int:
        """Where an output stands among those of its instance."""
        fmu = self.package.instance(source).fmu
        return fmu.variables[output].reference - fmu.of("output")[0].reference

    def states(self) -> dict[str, bytes]:
        """Serialised states of all instances."""
        return {name: serialised(slave) for name, slave in self.instances.items()}

    def free(self) -> None:
        """Give all instances back."""
        for slave in self.instances.values():
            slave.free()


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
        references = [instance.fmu.variables[name].reference for name in values]
        assert slave.set(references, list(values.values())), slave.last
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
