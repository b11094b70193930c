"""Results as a MAT file (v5) for MATLAB, Octave and SciPy.

One struct for each rate (`rate_0_25ms`) with `time` [s] and a field for each signal
(`plant_theta`, samples × axes), whose structs `unit`, `name` and `description` have the same
fields; `name` lists those of an array's elements where they have any. `meta` holds the provenance.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from scipy.io import savemat
from scipy.io.matlab import MatWriteError

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.result import Group, Meta, Result, plain

LONGEST = 63
"""Characters of a name in MATLAB."""


def write(path: Path, result: Result, meta: Meta) -> None:
    """Write the result; OSError when that fails, LogError when it is too large for MAT v5."""
    rates = identifiers(f"rate_{name}" for name in result.groups)
    content = {rates[f"rate_{name}"]: _struct(group) for name, group in result.groups.items()}
    keys = identifiers(sorted(meta))
    content["meta"] = {keys[key]: plain(meta[key]) for key in sorted(meta)}
    try:
        with path.open("wb") as file:
            savemat(file, content, long_field_names=True, do_compression=True, oned_as="column")
    except MatWriteError as error:
        raise LogError(f"{path}: too large for a MAT file, write .h5 instead ({error})") from None


def _struct(group: Group) -> dict[str, object]:
    fields = identifiers(group.signals)
    units: dict[str, object] = {"time": "s"}
    for signal, field in fields.items():
        each = group.column_units(signal)
        units[field] = each[0] if len(set(each)) == 1 else np.array(each, dtype=object)
    samples = {field: group.signals[signal] for signal, field in fields.items()}
    names = {
        field: np.array(group.columns(signal), dtype=object) if signal in group.elements else signal
        for signal, field in fields.items()
    }
    texts = {field: group.descriptions.get(signal, "") for signal, field in fields.items()}
    return {"time": group.time, **samples, "unit": units, "name": names, "description": texts}


def identifiers(names: Iterable[str]) -> dict[str, str]:
    """A name that MATLAB accepts for each name, no two alike: letters, digits, `_`."""
    names_of: dict[str, str] = {}
    taken = {"time", "unit", "name", "description"}
    for name in names:
        plain_name = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "x"
        plain_name = plain_name if plain_name[0].isalpha() else f"x{plain_name}"
        candidate, count = plain_name[:LONGEST], 1
        while candidate in taken:
            count += 1
            end = f"_{count}"
            candidate = plain_name[: LONGEST - len(end)] + end
        names_of[name] = candidate
        taken.add(candidate)
    return names_of
