"""Plain data of a machine file as TOML text; every number reads back exactly."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any


def toml_text(
    data: Mapping[str, Any], lists: Mapping[str, Sequence[Any]], head: Sequence[str] = ()
) -> str:
    """TOML of top-level values and sections, then of lists of tables; head: comment lines.

    A table with a `value` is a quantity and stands on one line.
    """
    lines = [f"# {' '.join(line.split())}" for line in head]
    lines += [f"{_key(k)} = {_value(v)}" for k, v in data.items() if not isinstance(v, Mapping)]
    for key, section in data.items():
        if isinstance(section, Mapping):
            lines += _section(_key(key), section, "[{}]")
    for key, entries in lists.items():
        for entry in entries:
            lines += _section(key, entry, "[[{}]]")
    return "\n".join(lines) + "\n"


def _section(name: str, table: Mapping[str, Any], heading: str) -> list[str]:
    below = {k: v for k, v in table.items() if isinstance(v, Mapping) and "value" not in v}
    own = [f"{_key(key)} = {_value(v)}" for key, v in table.items() if key not in below]
    lines = ["", heading.format(name), *own] if own or not below else []
    for key, sub in below.items():
        lines += _section(f"{name}.{_key(key)}", sub, "[{}]")
    return lines


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, int):
        return str(value)
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
