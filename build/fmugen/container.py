"""One FMU out of several of ours: the parts' own sources, linked statically, and a schedule.

`container.c` runs the parts as an importer would that steps all of them at the base step, so
the container gives what the single FMUs give, to the last bit.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from flexhex.fmugen.block_sizes import state_sizes
from flexhex.fmugen.container_parts import NAME, Container
from flexhex.fmugen.container_table import parts_header
from flexhex.fmugen.fmu import build_fmu

STEP = Path(__file__).with_name("container.c")


def build_container(
    container: Container,
    out_dir: Path,
    cache: Path | None = None,
    platforms: Sequence[str] = (),
) -> Path:
    """Build `out_dir/controller.fmu`; platforms and what it raises as in build_fmu."""
    texts: dict[str, str] = {}
    for part in container.parts:
        texts |= part.texts
    objects = cache or out_dir / "cache"
    names = list(dict.fromkeys(part.interface.name for part in container.parts))
    counts = state_sizes([f"{NAME}_{name}" for name in names], texts, objects)
    sizes = dict(zip(names, counts, strict=True))
    texts[f"{NAME}_parts.h"] = parts_header(container, sizes)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / NAME
        folder.mkdir()
        (folder / "step.c").write_text(STEP.read_text(encoding="utf-8"), encoding="utf-8")
        (folder / "README.md").write_text(_readme(container), encoding="utf-8")
        step, base = folder / "step.c", container.base
        return build_fmu(
            container.interface, [], step, out_dir, base, objects, platforms, more=texts
        )


def _readme(container: Container) -> str:
    rows = [
        f"| `{p.name}` | {p.interface.description} | {p.interface.Ts * 1e3:g} ms |"
        for p in container.parts
    ]
    return "\n".join(
        [
            "# Controller",
            "Several FMUs as one. Each part keeps its own sample time; all is stepped at the base"
            " step. `fault` is the highest of the parts' faults.",
            "",
            "| part | is | Ts |",
            "|---|---|---|",
            *rows,
            "",
        ]
    )
