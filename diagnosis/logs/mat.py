"""MAT logs: v5 by SciPy, v7.3 (HDF5) by h5py.

Variables `time`, `theta`, `tau_meas` ... (samples × axes or its transpose) stand side by side or
in structs, one struct for each rate. Units: a struct `unit` (or `units`) with fields by channel,
or variables such as `theta_unit`. A struct `name` tells the full name of a field, as in the files
of `flexhex simulate`. Texts and single numbers are metadata.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flexhex.diagnosis.logs.hdf5 import table_of
from flexhex.diagnosis.logs.log import Finding, Options
from flexhex.diagnosis.logs.mat5 import ObjectError, walk
from flexhex.diagnosis.logs.raw import CHANNELS, Raw
from flexhex.fmus.common.errors import LogError

UNIT_STRUCTS = ("unit", "units")
TIMES = ("time", "t")
OBJECT = 3
"""Mark of a v7.3 file on objects of MATLAB's own classes."""
TEXT_STRUCTS = (*UNIT_STRUCTS, "name", "description")


@dataclass(frozen=True)
class Turned:
    """A dataset of a v7.3 file as MATLAB shows it: its axes are stored the other way round."""

    item: Any

    @property
    def shape(self) -> tuple[int, ...]:
        """As `size` tells in MATLAB."""
        return tuple(reversed(self.item.shape))

    @property
    def dtype(self) -> Any:
        """Type of the numbers."""
        return self.item.dtype

    def __getitem__(self, key: Any) -> Any:
        turned = tuple(reversed(key)) if isinstance(key, tuple) else key
        return np.asarray(self.item[turned]).T


def read_mat(path: Path, options: Options) -> Raw:
    """Read a MAT file of either kind; LogError when it is neither."""
    try:
        if h5py.is_hdf5(path):
            objects: list[tuple[str, str]] = []
            with h5py.File(path, "r") as file:
                content = _hdf5(file, objects)
                if objects and not _has_time(content):
                    raise ObjectError(*objects[0])
                return _raw(path, content, options)
        return _raw(path, _version5(path), options)
    except LogError:
        raise
    except ObjectError as error:
        raise LogError(_plain(path, error.name, error.kind)) from None
    except Exception as error:  # scipy raises whatever a mangled file makes it meet
        reason = str(error) or type(error).__name__
        raise LogError(f"{path}: not a readable MAT file, maybe truncated ({reason})") from None


def _has_time(content: Mapping[str, Any]) -> bool:
    """Whether a variable, or a field of a struct, is one of times."""
    inside = (item for item in content.values() if isinstance(item, Mapping))
    return any(name.lower() in TIMES for name in content) or any(map(_has_time, inside))


def _plain(path: Path, name: str, kind: str) -> str:
    """How to save an object of MATLAB's as numbers."""
    said = f"{path}: {name} is a {kind}, which MATLAB alone can read: save numbers. "
    if kind == "timeseries":
        return said + f"In MATLAB: time = {name}.Time; theta = {name}.Data; ... save run time theta"
    if kind not in ("timetable", "table"):
        return said + "In MATLAB: save run time theta tau_meas unit, each a matrix"
    of = f"seconds({name}.Properties.RowTimes)" if kind == "timetable" else f"{name}.time"
    return (
        said
        + (
            f"In MATLAB: time = {of}; theta = {name}.theta; tau_meas = {name}.tau_meas;"
            " unit.theta = 'rad'; unit.tau_meas = 'N m'; save run time theta tau_meas unit"
        )
        + (f"; or writetimetable({name}, 'run.csv')" if kind == "timetable" else "")
    )


def _version5(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    walk(path.read_bytes())
    content = loadmat(str(path), simplify_cells=True)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _hdf5(group: h5py.Group, objects: list[tuple[str, str]]) -> dict[str, Any]:
    """Nested content of a v7.3 file; texts are stored as numbers of characters there. objects:
    takes name and class of what MATLAB alone can read."""
    content: dict[str, Any] = {}
    for name, item in group.items():
        if name.startswith("#"):
            continue
        if isinstance(item, h5py.Group):
            content[name] = _hdf5(item, objects)
        elif item.attrs.get("MATLAB_class") == b"char":
            content[name] = "".join(chr(int(c)) for c in np.asarray(item[()]).ravel(order="K"))
        elif item.attrs.get("MATLAB_empty"):
            continue
        elif item.attrs.get("MATLAB_object_decode") == OBJECT:
            kind = item.attrs.get("MATLAB_class", b"object")
            objects.append((name, kind.decode() if isinstance(kind, bytes) else str(kind)))
        else:
            content[name] = Turned(item)
    return content


def _raw(path: Path, content: Mapping[str, Any], options: Options) -> Raw:
    meta: dict[str, str] = {}
    tables, findings = [], list[Finding]()
    for where, group in _groups(str(path), content):
        units = _units(content) | _units(group)
        full = _texts(group.get("name"))
        units |= {full[field]: unit for field, unit in units.items() if field in full}
        data = {}
        for field, item in group.items():
            name = full.get(field, field)
            if isinstance(item, str):
                meta[name] = item
            elif _scalar(item):
                value = item[()] if hasattr(item, "shape") else item
                meta[name] = f"{float(np.ravel(value)[0]):.15g}"
            elif hasattr(item, "shape") and item.dtype.kind in "fiub":
                data[name] = item
        if not any(name.lower() in (*TIMES, *CHANNELS) for name in data):
            continue
        table, notes = table_of(where, _flat(data), units, options)
        findings += notes
        tables += [table] if table else []
    if not tables:
        shown = ", ".join(list(content)[:8]) or "nothing"
        raise LogError(f"{path}: no variable `time`; it has {shown}")
    return Raw(tables, meta, findings)


def _groups(where: str, content: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    groups: list[tuple[str, Mapping[str, Any]]] = [(where, content)]
    for name, item in content.items():
        if isinstance(item, Mapping) and not (name in TEXT_STRUCTS and _texts(item)):
            groups += _groups(f"{where}: {name}", item)
    return groups


def _units(group: Mapping[str, Any]) -> dict[str, str]:
    units = {
        name.removesuffix("_unit"): item
        for name, item in group.items()
        if name.endswith("_unit") and isinstance(item, str)
    }
    for name in UNIT_STRUCTS:
        units |= _texts(group.get(name))
    return units


def _texts(struct: Any) -> dict[str, str]:
    """The texts of a struct by field; nothing of what is no struct."""
    fields = struct.items() if isinstance(struct, Mapping) else ()
    return {key: item for key, item in fields if isinstance(item, str)}


def _scalar(item: Any) -> bool:
    if isinstance(item, int | float | np.number):
        return True
    return hasattr(item, "shape") and item.dtype.kind in "fiub" and np.prod(item.shape) == 1


def _flat(data: Mapping[str, Any]) -> dict[str, Any]:
    """Row and column vectors as vectors, so that time × axes decides about the rest."""
    flat = {}
    for name, item in data.items():
        vector = len(item.shape) == 2 and 1 in item.shape
        flat[name] = np.asarray(item[()]).ravel() if vector else item
    return flat
