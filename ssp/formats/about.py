"""What a result holds beside its samples, as JSON: in the metadata of MCAP, MAT and Parquet."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.result import FORMAT, VERSION, Array, FmuTime, Group, Meta, Result, plain

KEY = "flexhex_result"
"""Name under which it stands in a file of MAT or Parquet."""
Samples = Callable[[str, str], Array]
"""Samples by rate and signal, in any shape that has their order."""


def about_result(result: Result, meta: Meta) -> dict[str, Any]:
    """Format, provenance, times, and of each rate and signal all but the samples."""
    groups = {
        rate: {
            "period": group.period,
            "base": group.base,
            "signals": {
                signal: {
                    "shape": list(values.shape),
                    "unit": group.units.get(signal, ""),
                    "description": group.descriptions.get(signal, ""),
                    "elements": group.elements.get(signal),
                }
                for signal, values in group.signals.items()
            },
        }
        for rate, group in result.groups.items()
    }
    return {
        "format": FORMAT,
        "version": VERSION,
        "duration_s": result.duration,
        "wall_s": result.wall,
        "meta": {key: plain(value) for key, value in meta.items()},
        "times": {name: vars(spent) for name, spent in result.times.items()},
        "groups": groups,
    }


def refuse_version(path: object, about: dict[str, Any]) -> None:
    """LogError for a layout that this program does not know."""
    if about.get("version") != VERSION:
        raise LogError(
            f"{path}: version {about.get('version')} of the format, this program reads {VERSION}"
        )


def result_of(about: dict[str, Any], samples: Samples) -> Result:
    """The result again. KeyError, TypeError or ValueError where something is missing."""
    groups = {rate: _group(rate, entry, samples) for rate, entry in about["groups"].items()}
    times = {name: FmuTime(**spent) for name, spent in about["times"].items()}
    return Result(groups, times, about["duration_s"], about["wall_s"], about["meta"])


def _group(rate: str, entry: dict[str, Any], samples: Samples) -> Group:
    signals = {}
    for name, one in entry["signals"].items():
        rows, *columns = one["shape"]
        # files of before this module say 0 rows, whatever they hold
        signals[name] = samples(rate, name).reshape(rows or -1, *columns)
    each: dict[str, dict[str, Any]] = {
        key: {name: one[key] for name, one in entry["signals"].items()}
        for key in ("unit", "description", "elements")
    }
    elements = {name: tuple(parts) for name, parts in each["elements"].items() if parts}
    return Group(
        entry["period"], entry["base"], signals, each["unit"], each["description"], elements
    )
