"""Archives that are equal byte for byte when their contents are."""

from __future__ import annotations

import os
import threading
import zipfile
from collections.abc import Mapping
from pathlib import Path

_EPOCH = (1980, 1, 1, 0, 0, 0)


def scratch_file(target: Path) -> Path:
    """Neighbour of `target` that no other process or thread writes to; replace() it later."""
    return target.with_name(f".{target.name}.{os.getpid()}.{threading.get_ident()}")


def write_file(target: Path, data: bytes) -> Path:
    """Write a file that appears under its name when it is complete."""
    target.parent.mkdir(parents=True, exist_ok=True)
    scratch = scratch_file(target)
    scratch.write_bytes(data)
    return scratch.replace(target)


def write_zip(target: Path, files: Mapping[str, bytes]) -> Path:
    """Write files (archive name -> contents) sorted, with a fixed date; replaces atomically."""
    target.parent.mkdir(parents=True, exist_ok=True)
    scratch = scratch_file(target)
    with zipfile.ZipFile(scratch, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _EPOCH)
            # FMUs too: a truncated .ssp must not be taken for the stored FMU at its end
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
            entry.create_system = 3
            archive.writestr(entry, files[name])
    scratch.replace(target)
    return target
