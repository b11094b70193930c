"""Results as one Parquet table, with the extra `parquet`.

A row for each instant at which any rate has a sample; a column for each scalar
(`plant.theta[1]`), null where its rate has no sample. Unit and description stand in the
metadata of each field, the provenance in that of the table, and under `flexhex_result` what reads
a result back exactly.
"""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.ssp.formats.about import KEY, about_result, refuse_version, result_of
from flexhex.ssp.result import FORMAT, VERSION, Group, Meta, Result

PACKAGE = "needs the package pyarrow: pip install 'flexhex[parquet]'"


def check_installed(path: Path) -> None:
    """UsageError where pyarrow is missing."""
    try:
        importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise UsageError(f"{path}: writing .parquet {PACKAGE}") from None


def write(path: Path, result: Result, meta: Meta) -> None:
    """Write the result; OSError when that fails, UsageError without pyarrow."""
    check_installed(path)
    arrow = importlib.import_module("pyarrow")
    groups = list(result.groups.values())
    base = groups[0].base
    counts = [np.arange(group.rows, dtype=np.int64) * group.period for group in groups]
    instants = np.unique(np.concatenate(counts))
    fields, columns = [_field(arrow, "time", "s", "time")], [arrow.array(instants * base)]
    for group, own in zip(groups, counts, strict=True):
        # row of its sample at each instant, null where it has none
        rows = np.searchsorted(own, instants).clip(max=len(own) - 1)
        empty = own[rows] != instants
        for name, unit, text, values in _scalars(group):
            fields.append(_field(arrow, name, unit, text))
            columns.append(arrow.array(values[rows], mask=empty))
    facts = {"format": FORMAT, "version": VERSION, "base_step_s": base} | dict(meta)
    texts = {key: str(value) for key, value in facts.items()}
    texts[KEY] = json.dumps(about_result(result, meta))
    schema = arrow.schema(fields, metadata=texts)
    table = arrow.table(columns, schema=schema)
    importlib.import_module("pyarrow.parquet").write_table(table, path)


def read(path: Path) -> Result:
    """Read a result that `write` wrote. LogError when it is none or damaged, or without pyarrow."""
    try:
        parquet = importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise LogError(f"{path}: reading .parquet {PACKAGE}") from None
    try:
        table = parquet.read_table(path)
        text = (table.schema.metadata or {}).get(KEY.encode())
    except Exception as error:  # pyarrow's own classes
        raise LogError(f"{path}: not a readable Parquet file ({error})") from None
    if text is None:
        raise LogError(f"{path}: a Parquet file, but not a result: its metadata has no `{KEY}`")
    try:
        about = json.loads(text)
        refuse_version(path, about)
        columns = iter(table.columns[1:])
        # a null is no sample, a NaN is one
        values = {
            (rate, signal): np.stack(
                [
                    next(columns).drop_null().to_numpy()
                    for _ in range(max(one["shape"][1:], default=1))
                ],
                axis=-1,
            )
            for rate, entry in about["groups"].items()
            for signal, one in entry["signals"].items()
        }
        return result_of(about, lambda rate, signal: values[rate, signal])
    except (ValueError, KeyError, TypeError, AttributeError, StopIteration) as error:
        raise LogError(f"{path}: a damaged result ({error})") from None


def _scalars(group: Group) -> list[tuple[str, str, str, Any]]:
    """Name, unit, description and samples (n,) of every scalar."""
    return [
        (name, unit, group.descriptions.get(signal, ""), values.reshape(len(values), -1)[:, k])
        for signal, values in group.signals.items()
        for k, (name, unit) in enumerate(
            zip(group.columns(signal), group.column_units(signal), strict=True)
        )
    ]


def _field(arrow: Any, name: str, unit: str, description: str) -> Any:
    return arrow.field(name, arrow.float64(), metadata={"unit": unit, "description": description})
