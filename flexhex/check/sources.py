"""Whether the sources that an FMU of flexhex carries compile."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from flexhex.check.subject import Subject
from flexhex.fmugen.compile import compiler
from flexhex.fmus.common.errors import BuildError


def sources(subject: Subject) -> Iterator[str]:
    """The first objection of the compiler to each C file; none without a compiler.

    Of FMUs of others it is not known with which options they compile.
    """
    names = [n for n in subject.names if n.startswith("sources/") and n.endswith((".c", ".h"))]
    if not subject.ours or not names:
        return
    try:
        command = [*compiler(), "-std=c99", "-fsyntax-only", "-w"]
    except BuildError:
        return
    with tempfile.TemporaryDirectory() as folder, subject.archive() as archive:
        for name in names:
            archive.extract(name, folder)
        for name in (n for n in names if n.endswith(".c")):
            done = subprocess.run(
                [*command, Path(name).name],
                cwd=(Path(folder) / name).parent,
                capture_output=True,
                text=True,
                errors="replace",
                check=False,
            )
            if done.returncode:
                errors = [line for line in done.stderr.splitlines() if "error" in line]
                yield f"{name} does not compile: {(errors or ['no message'])[0]}"
