"""Results as a MAT file (v5) for MATLAB, Octave and SciPy.

One struct for each rate (`rate_0_25ms`) with `time` [s] and a field for each signal
(`plant_theta`, samples × axes), whose structs `unit`, `name` and `description` have the same
fields; `name` lists those of an array's elements where they have any. `meta` holds the provenance,
`flexhex_result` as JSON what reads a result back exactly.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, savemat
from scipy.io.matlab import MatWriteError

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.formats.about import KEY, about_result, refuse_version, result_of
from flexhex.ssp.result import Array, Group, Meta, Result, plain

LONGEST = 63
"""Characters of a name in MATLAB."""


def write(path: Path, result: Result, meta: Meta) -> None:
    """Write the result; OSError when that fails, LogError when it is too large for MAT v5."""
    rates = _rates(result.groups)
    content: dict[str, Any] = {rates[name]: _struct(group) for name, group in result.groups.items()}
    keys = identifiers(sorted(meta))
    content["meta"] = {keys[key]: plain(meta[key]) for key in sorted(meta)}
    content[KEY] = json.dumps(about_result(result, meta))
    try:
        with path.open("wb") as file:
            savemat(file, content, long_field_names=True, do_compression=True, oned_as="column")
    except MatWriteError as error:
        raise LogError(f"{path}: too large for a MAT file, write .h5 instead ({error})") from None


def read(path: Path) -> Result:
    """Read a result that `write` wrote. LogError when it is none, or damaged."""
    try:
        text = loadmat(str(path), variable_names=[KEY], simplify_cells=True).get(KEY)
    except NotImplementedError:  # v7.3, as MATLAB writes it
        text = None
    except Exception as error:  # scipy raises whatever a mangled file makes it meet
        raise LogError(f"{path}: not a readable MAT result, maybe truncated ({error})") from None
    if text is None:
        raise LogError(f"{path}: a MAT file, but not a result: it has no variable `{KEY}`")
    try:
        about = json.loads(text)
        refuse_version(path, about)
        rates = _rates(about["groups"])
        structs = loadmat(str(path), variable_names=list(rates.values()), simplify_cells=True)

        def samples(rate: str, signal: str) -> Array:
            field = identifiers(about["groups"][rate]["signals"])[signal]
            return np.asarray(structs[rates[rate]][field], dtype=np.float64)

        return result_of(about, samples)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise LogError(f"{path}: a damaged result ({error})") from None


def _rates(groups: Iterable[str]) -> dict[str, str]:
    """Name of the struct of each rate."""
    names = list(groups)
    return dict(zip(names, identifiers(f"rate_{name}" for name in names).values(), strict=True))


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
