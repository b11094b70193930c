"""Published figures of a machine, to stand beside simulated ones: `tflex-published.toml`.

They belong to one machine file by its name, so that a copy with other values has none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pydantic import BaseModel, ConfigDict, FiniteFloat, ValidationError

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine_file import read_toml
from flexhex.simulation.metrics import KEYS


class Published(BaseModel):
    """source: where they stand. rows: case -> figures in the order of `metrics.Figures`, maybe
    fewer. caveat: sentences on what a comparison with them can show. repeatable_share: of the
    feedback torque that adaptive feedforward leaves."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    source: str
    rows: Mapping[str, tuple[FiniteFloat, ...]]
    caveat: str = ""
    repeatable_share: FiniteFloat | None = None


def published_file(machine_file: Path) -> Path:
    """`tflex.toml` -> `tflex-published.toml`."""
    return machine_file.with_name(f"{machine_file.stem}-published.toml")


def published(machine_file: Path) -> Published | None:
    """Figures published of this machine; None without such a file. MachineError for a bad one."""
    path = published_file(machine_file)
    if not path.exists():
        return None
    try:
        return Published.model_validate(read_toml(path))
    except ValidationError as error:
        raise MachineError("\n".join(complaints(path, Published, error.errors()))) from None


def published_row(values: Sequence[float]) -> dict[str, str | float | None]:
    """A row of published figures, grey."""
    full: list[float | None] = [*values, *[None] * (len(KEYS) - len(values))]
    return {"title": "  published", "class": "dim"} | dict(zip(KEYS, full, strict=True))
