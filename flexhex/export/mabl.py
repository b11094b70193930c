"""A .ssp as a program for Maestro's interpreter (MaBL): a loop over arrays, every base step.

Maestro makes such a program itself from `maestro.json`, but compares its statements pairwise on
the way, which all FMUs of the loop outlast. `mabl interpret maestro.mabl -runtime maestro-run.json`
runs this one as it stands.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from flexhex.ssp.read import Instance, Package

HEAD = """simulation
import FMI2;
import FMI2Component;
import DataWriter;
import DataWriterConfig;
{"""
RESULT = "outputs.csv"


TYPES: Mapping[str, tuple[Callable[[float], float], str, str]] = {
    "Real": (float, "real", "setReal"),
    "Integer": (int, "int", "setInteger"),
    "Enumeration": (int, "int", "setInteger"),
    "Boolean": (bool, "bool", "setBoolean"),
}
"""FMI's type -> Python's, MaBL's, and what sets it."""


def other_values(instance: Instance) -> dict[str, float]:
    """Parameters to which the .ssp gives another value than the FMU starts with, as their type."""
    variables = instance.fmu.variables
    other = {n: v for n, v in instance.parameters.items() if v != variables[n].start}
    return {n: TYPES[variables[n].type][0](v) for n, v in other.items()}


def runtime(package: Package, seconds: float) -> str:
    """Where Maestro's interpreter writes the results."""
    writer = [{"filename": RESULT, "type": "CSV"}]
    return json.dumps({"environment_variables": {}, "DataWriter": writer}, indent=1) + "\n"


def mabl(package: Package, seconds: float) -> str:
    """The program: load, initialise, step all with the outputs of one instant, record, unload."""
    parts = [_Part.of(instance, package) for instance in package.instances]
    names = ", ".join(f'"{p.name}.{output}"' for p in parts for output in p.outputs)
    values = "".join(f", {p.id}_y[{k}]" for p in parts for k in range(len(p.outputs)))
    lines = [
        "int status = 0;",
        "real n = 0.0;",
        f"real steps = {seconds / package.base:.1f};",
        f"real h = {package.base!r};",
        'DataWriter writer = load("DataWriter");',
        *(line for p in parts for line in p.loaded()),
        *(line for p in parts for line in p.initialised()),
        *(line for p in parts for line in p.read()),
        f"string names[{sum(len(p.outputs) for p in parts)}] = {{{names}}};",
        "DataWriterConfig table = writer.writeHeader(names);",
        f"writer.writeDataPoint(table, n * h{values});",
        "while (n < steps)",
        "{",
        *(f"  {line}" for p in parts for line in p.fed()),
        *(f"  {line}" for p in parts for line in p.stepped()),
        *(f"  {line}" for p in parts for line in p.read()),
        "  n = n + 1.0;",
        f"  writer.writeDataPoint(table, n * h{values});",
        "}",
        "writer.close();",
        *(line for p in parts for line in p.unloaded()),
        "unload(writer);",
    ]
    return "\n".join([HEAD, *(f"  {line}" for line in lines), "}", ""])


@dataclass(frozen=True)
class _Part:
    """One component: its connected outputs, and where each connected input comes from."""

    instance: Instance
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    sources: tuple[str, ...]
    """Elements of other components' arrays, one for each of the inputs."""

    @classmethod
    def of(cls, instance: Instance, package: Package) -> _Part:
        feeding = [w for w in package.wires if w.target == instance.name]
        places = [
            f"{_identifier(w.source)}_y[{_connected(w.source, package).index(w.output)}]"
            for w in feeding
        ]
        inputs = tuple(w.input for w in feeding)
        return cls(instance, _connected(instance.name, package), inputs, tuple(places))

    @property
    def name(self) -> str:
        return self.instance.name

    @property
    def id(self) -> str:
        return _identifier(self.name)

    def loaded(self) -> Iterator[str]:
        file, guid = Path(self.instance.source).name, self.instance.fmu.guid
        yield f'FMI2 {self.id}_fmu = load("FMI2", "{guid}", "{file}");'
        yield f'FMI2Component {self.id} = {self.id}_fmu.instantiate("{self.name}", false, false);'
        yield from self._array("y", self.outputs)
        yield from self._array("u", self.inputs)

    def _array(self, letter: str, names: Sequence[str], of: str = "real") -> Iterator[str]:
        if names:
            references = ", ".join(str(self.instance.fmu.variables[n].reference) for n in names)
            yield f"uint {self.id}_{letter}_refs[{len(names)}] = {{{references}}};"
            yield f"{of} {self.id}_{letter}[{len(names)}];"

    def initialised(self) -> Iterator[str]:
        yield from self._call("setupExperiment(false, 0.0, 0.0, false, 0.0)", "setupExperiment")
        values, variables = other_values(self.instance), self.instance.fmu.variables
        for _, of, setter in dict.fromkeys(TYPES.values()):
            mine = {n: v for n, v in values.items() if TYPES[variables[n].type][2] == setter}
            array = f"p_{of}"
            yield from self._array(array, list(mine), of)
            for k, value in enumerate(mine.values()):
                yield f"{self.id}_{array}[{k}] = {json.dumps(value)};"
            if mine:
                where = f"{self.id}_{array}"
                yield from self._call(f"{setter}({where}_refs, {len(mine)}, {where})")
        yield from self._call("enterInitializationMode()")
        yield from self._call("exitInitializationMode()")

    def read(self) -> Iterator[str]:
        if self.outputs:
            yield from self._call(f"getReal({self.id}_y_refs, {len(self.outputs)}, {self.id}_y)")

    def fed(self) -> Iterator[str]:
        yield from (f"{self.id}_u[{k}] = {source};" for k, source in enumerate(self.sources))
        if self.inputs:
            yield from self._call(f"setReal({self.id}_u_refs, {len(self.inputs)}, {self.id}_u)")

    def stepped(self) -> Iterator[str]:
        yield from self._call("doStep(n * h, h, false)")

    def unloaded(self) -> Iterator[str]:
        yield from self._call("terminate()")
        yield f"{self.id}_fmu.freeInstance({self.id});"
        yield f"unload({self.id}_fmu);"

    def _call(self, call: str, name: str = "") -> Iterator[str]:
        yield f"status = {self.id}.{call};"
        yield f'if (status > 1) {{ error "{self.name}: {name or call.partition("(")[0]} failed"; }}'


def _connected(component: str, package: Package) -> tuple[str, ...]:
    """Outputs of a component that go or are shown somewhere, in the order of its FMU."""
    wired = {w.output for w in package.wires if w.source == component}
    return tuple(v.name for v in package.instance(component).fmu.of("output") if v.name in wired)


def _identifier(name: str) -> str:
    return "c_" + re.sub(r"\W", "_", name)
