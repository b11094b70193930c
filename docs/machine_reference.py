"""Writes docs/machine-file.md from the model of a machine file.

python docs/machine_reference.py
"""

from __future__ import annotations

import inspect
import tomllib
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine.quantity import SOURCES, Quantity

HERE = Path(__file__).resolve().parent
EXAMPLE = HERE.parent / "machines" / "tflex.toml"
HEAD = f"""# Machine file
Every key of a machine file, as the program checks it. `docs/machine_reference.py` writes this page
from the model in `fmus/common/machine`; the values are those of `machines/tflex.toml`.

Most keys are quantities, `m = {{ value = 0.5, unit = "kg", source = "assumed", note = "..." }}`.
The unit must be the one below: nothing is converted. `source` is one of
{", ".join(f"`{s}`" for s in SOURCES)}; `note` is free. A key that is marked
optional may be left out.

`flexhex check FILE` reads a machine file and says what is wrong, where, and how to mend it.
"""


def sections(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, type[BaseModel]]]:
    """All tables of the file by name, `bodies.upper`; lists of tables as `[arms]`."""
    for name, field in model.model_fields.items():
        part = _model(field)
        if part is not None:
            many = "tuple" in str(field.annotation)
            key = f"{path}.{name}" if path else name
            yield (f"[{key}]" if many else key), part
            yield from sections(part, key)


def _model(field: FieldInfo) -> type[BaseModel] | None:
    """The model of a field that is a table, or of the entries of one that is a list of tables."""
    for kind in (field.annotation, *typing.get_args(field.annotation)):
        if inspect.isclass(kind) and issubclass(kind, BaseModel):
            return kind
    return None


def _unit(field: FieldInfo) -> str:
    return next((m.unit for m in field.metadata if isinstance(m, Quantity)), "–")


def _shown(entry: Any) -> tuple[str, str, str]:
    """Value, source, note of a key of the example."""
    if isinstance(entry, dict) and "value" in entry:
        value = entry["value"]
        rows = isinstance(value, list) and isinstance(value[0], list)
        text = f"{len(value)} × {len(value[0])} numbers" if rows else _number(value)
        return text, entry["source"], entry.get("note", "")
    if entry is None or isinstance(entry, (dict, list)):
        return "", "", ""
    return str(entry), "", ""


def _number(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_number(v) for v in value) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def table(model: type[BaseModel], example: dict[str, Any]) -> list[str]:
    """Rows of one table of the file."""
    lines = ["| key | unit | T-Flex | source | note |", "| --- | --- | --- | --- | --- |"]
    for name, field in model.model_fields.items():
        if _model(field) is None and not field.exclude:
            value, source, note = _shown(example.get(name))
            optional = "" if field.is_required() else " (optional)"
            note = note.replace("|", "\\|")
            lines.append(f"| `{name}`{optional} | {_unit(field)} | {value} | {source} | {note} |")
    return lines if len(lines) > 2 else []


def text() -> str:
    """The whole page."""
    data = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
    lines = [HEAD, "## At the top", *table(Machine, data)]
    for name, model in sections(Machine):
        example: Any = data
        for key in name.strip("[]").split("."):
            example = example.get(key, {}) if isinstance(example, dict) else {}
        example = example[0] if isinstance(example, list) and example else example
        said = " ".join((inspect.getdoc(model) or "").split())
        rows = table(model, example or {})
        lines += ["", f"## `[{name}]`", said, *(["", *rows] if rows else [])]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (HERE / "machine-file.md").write_text(text(), encoding="utf-8")
