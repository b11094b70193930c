"""A .ssp's wiring in the formats of importers that do not read .ssp, beside its FMUs."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from lxml import etree

from flexhex.export.mabl import mabl, other_values, runtime
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.interface import written
from flexhex.ssp.read import Instance, Package, read_ssp

OSP = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"


def export_wiring(path: Path, out: Path, tool: str, seconds: float) -> list[Path]:
    """Write the FMUs of a .ssp and the wiring for one tool into `out`.

    seconds: where Maestro stops; the others are told when they run. Raises UsageError for a
    tool without a format, InterfaceError for a .ssp that cannot be read.
    """
    if tool not in WIRINGS:
        raise UsageError(f"no wiring for {tool!r}, there is one for: {', '.join(sorted(WIRINGS))}")
    package = read_ssp(path)
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for source, data in package.fmus.items():
        written.append(out / Path(source).name)
        written[-1].write_bytes(data)
    for name, write in WIRINGS[tool].items():
        written.append(out / name)
        written[-1].write_text(write(package, seconds), encoding="utf-8")
    return written


def _file(instance: Instance) -> str:
    return Path(instance.source).name


def cofmupy(package: Package, seconds: float) -> str:
    """Configuration of CoFMPy: `Coordinator().start("cofmupy.json")`."""
    fmus = [
        {"id": i.name, "path": _file(i), "initialization": other_values(i)}
        for i in package.instances
    ]
    wires = [
        {
            "source": {"id": w.source, "variable": w.output},
            "target": [{"id": w.target, "variable": w.input}],
        }
        for w in package.wires
    ]
    config = {"cosim_method": "jacobi", "iterative": False, "fmus": fmus, "connections": wires}
    return json.dumps(config, indent=1) + "\n"


def maestro(package: Package, seconds: float) -> str:
    """Multi-model of INTO-CPS Maestro 2, `import Sg1 maestro.json`: for a few FMUs, see mabl."""
    keys = {i.name: f"{{{Path(i.source).stem}}}.{i.name}" for i in package.instances}
    wires: dict[str, list[str]] = {}
    for w in package.wires:
        targets = wires.setdefault(f"{keys[w.source]}.{w.output}", [])
        targets.append(f"{keys[w.target]}.{w.input}")
    config = {
        "fmus": {f"{{{Path(i.source).stem}}}": _file(i) for i in package.instances},
        "connections": wires,
        "parameters": {
            f"{keys[i.name]}.{name}": value
            for i in package.instances
            for name, value in other_values(i).items()
        },
        "algorithm": {"type": "fixed-step", "size": package.base},
        "startTime": 0.0,
        "endTime": seconds,
        "loggingOn": False,
        "visible": False,
        "parallelSimulation": False,
        "stabalizationEnabled": False,  # spelt as Maestro spells it
    }
    return json.dumps(config, indent=1) + "\n"


def osp(package: Package, seconds: float) -> str:
    """OspSystemStructure.xml of the Open Simulation Platform (libcosim, cosim, Kopl)."""
    # the stubs of lxml know no default namespace
    spaces: Any = {None: OSP}
    root = etree.Element(f"{{{OSP}}}OspSystemStructure", {"version": "0.1"}, nsmap=spaces)
    _text(root, "StartTime", "0.0")
    _text(root, "BaseStepSize", repr(package.base))
    _text(root, "Algorithm", "fixedStep")
    simulators = etree.SubElement(root, f"{{{OSP}}}Simulators")
    for instance in package.instances:
        attributes = {"name": instance.name, "source": _file(instance)}
        simulator = etree.SubElement(simulators, f"{{{OSP}}}Simulator", attributes)
        values = other_values(instance)
        if values:
            _initial(etree.SubElement(simulator, f"{{{OSP}}}InitialValues"), values)
    connections = etree.SubElement(root, f"{{{OSP}}}Connections")
    for w in package.wires:
        pair = etree.SubElement(connections, f"{{{OSP}}}VariableConnection")
        for component, variable in ((w.source, w.output), (w.target, w.input)):
            end = {"simulator": component, "name": variable}
            etree.SubElement(pair, f"{{{OSP}}}Variable", end)
    text = etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")
    return bytes(text).decode()


def _text(parent: etree._Element, tag: str, text: str) -> None:
    etree.SubElement(parent, f"{{{OSP}}}{tag}").text = text


def _initial(parent: etree._Element, values: Mapping[str, float]) -> None:
    for name, value in values.items():
        entry = etree.SubElement(parent, f"{{{OSP}}}InitialValue", variable=name)
        of = {bool: "Boolean", int: "Integer", float: "Real"}[type(value)]
        etree.SubElement(entry, f"{{{OSP}}}{of}", value=written(of, value))


Writer = Callable[[Package, float], str]
WIRINGS: Mapping[str, Mapping[str, Writer]] = {
    "cofmupy": {"cofmupy.json": cofmupy},
    "maestro": {"maestro.json": maestro, "maestro-run.json": runtime, "maestro.mabl": mabl},
    "osp": {"OspSystemStructure.xml": osp},
}
"""Tool -> name and writer of each of its files, the one that runs all last."""
