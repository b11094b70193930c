"""Sizes of the states of FMUs, as their compiled step.c gives them."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from flexhex.fmugen.compile import SMALL, compile_object, link_shared
from flexhex.fmugen.fmu import RUNTIME

_PROBE_C = """#include "block.h"
{externs}
__attribute__((visibility("default"))) size_t block_state(int k);
size_t block_state(int k) {{
  const flexhex_block *blocks[] = {{{blocks}}};
  return blocks[k]->state;
}}
"""


def state_sizes(blocks: Sequence[str], texts: Mapping[str, str], cache: Path) -> list[int]:
    """Doubles that hold the state of each `<name>_block`; texts: their sources, by file name.

    The sizes hold where `size_t`, `int` and pointers are not larger than here; container.c
    refuses to start elsewhere. Raises BuildError when the compiler fails.
    """
    cache.mkdir(parents=True, exist_ok=True)
    externs = "\n".join(f"extern const flexhex_block {block}_block;" for block in blocks)
    listed = ", ".join(f"&{block}_block" for block in blocks)
    shared = {
        name: (RUNTIME / name).read_text(encoding="utf-8")
        for name in ("block.h", "pair.h", "wide.h")
    }
    files = {**texts, **shared}
    files["probe.c"] = _PROBE_C.format(externs=externs, blocks=listed)
    headers = "\0".join(text for name, text in sorted(files.items()) if name.endswith(".h"))
    with tempfile.TemporaryDirectory(dir=cache) as folder:
        work, objects = Path(folder), []
        for name, text in files.items():
            (work / name).write_text(text, encoding="utf-8")
        for name in sorted(name for name in files if name.endswith(".c")):
            seen = "" if name.endswith("_casadi.c") else headers
            objects.append(compile_object(work / name, seen, cache, SMALL))
        library = ctypes.CDLL(str(link_shared(objects, work / "probe.so").resolve()))
        library.block_state.restype = ctypes.c_size_t
        bytes_ = [library.block_state(k) for k in range(len(blocks))]
    # whole doubles, sixteen bytes at least: no FMU's numbers share a cache line with the next one's
    return [(size + 15) // 16 * 2 for size in bytes_]
