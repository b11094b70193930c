"""All variables of FMUs as one table (CSV), for people and for tools that map names."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from lxml import etree

from flexhex.fmus.common.archive import open_zip, read_bytes, read_member
from flexhex.fmus.common.errors import UsageError
from flexhex.ssp.fmu import TYPES, read_fmu
from flexhex.ssp.read import read_ssp

COLUMNS = (
    "fmu", "name", "valueReference", "causality", "variability", "type", "unit", "display unit",
    "start", "min", "max", "description",
)  # fmt: skip


def export_variables(paths: Sequence[Path], target: Path) -> Path:
    """Write the variables of FMUs, and of all FMUs in a .ssp, each FMU once.

    UsageError for a file of another kind, InterfaceError for one that cannot be read.
    """
    rows = [row for name, data in _fmus(paths).items() for row in variable_rows(name, data)]
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    return target


def _fmus(paths: Sequence[Path]) -> dict[str, bytes]:
    fmus: dict[str, bytes] = {}
    for path in paths:
        if path.suffix == ".ssp":
            fmus |= {Path(s).name: data for s, data in read_ssp(path).fmus.items()}
        elif path.suffix == ".fmu":
            fmus[path.name] = read_bytes(path)
        else:
            raise UsageError(f"{path}: wants .fmu or .ssp")
    return fmus


def variable_rows(name: str, data: bytes) -> Iterable[tuple[str, ...]]:
    """One row a scalar variable, numbers as the FMU writes them."""
    known = read_fmu(data, name).variables
    root = etree.fromstring(read_member(open_zip(data, name), "modelDescription.xml", name))
    shown = {str(u.get("name")): _display(u) for u in root.iterfind("UnitDefinitions/Unit")}
    for variable in root.iterfind("ModelVariables/ScalarVariable"):
        typed = next(e for e in variable if e.tag in TYPES)
        unit = typed.get("unit", "")
        yield (
            name,
            variable.get("name", ""),
            variable.get("valueReference", ""),
            variable.get("causality", "local"),
            variable.get("variability", "continuous"),
            str(typed.tag),
            unit,
            typed.get("displayUnit", shown.get(unit, "")),
            typed.get("start", ""),
            typed.get("min", ""),
            typed.get("max", ""),
            known[variable.get("name", "")].description,
        )


def _display(unit: etree._Element) -> str:
    """The first display unit that an FMU offers for a unit."""
    display = unit.find("DisplayUnit")
    return "" if display is None else display.get("name", "")
