"""Fuzz FMUs: `python -m tests.conformity.fuzz --calls 1000000 out/fmus/*.fmu` (`make fuzz`)."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from flexhex.fmugen.compile import compile_object, compiler
from tests.conformity.archives import members

HERE = Path(__file__).parent
OWN = ("fuzz.c", "fuzz.h", "fuzz_calls.h")
SANITIZE = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
FLAGS = ("-g", "-O1", *SANITIZE)
CACHE = HERE.parents[1] / "out" / "cache" / "fuzz"


def has_sanitizers(folder: Path) -> bool:
    """Whether the compiler can link and run with them."""
    probe = folder / "probe.c"
    probe.write_text("int main(void) { return 0; }\n")
    command = [*compiler(), *FLAGS, str(probe), "-o", str(folder / "probe")]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def build(fmu: Path, folder: Path) -> Path:
    """The fuzzer linked with an FMU's sources; objects are kept between runs."""
    headers = [(HERE / name).read_text() for name in OWN if name.endswith(".h")]
    for name, data in sorted(members(fmu).items()):
        if name.startswith("sources/") and name.endswith((".c", ".h")):
            (folder / Path(name).name).write_bytes(data)
            headers += [data.decode()] if name.endswith(".h") else []
    for name in OWN:
        (folder / name).write_bytes((HERE / name).read_bytes())
    sources = sorted(folder.glob("*.c"))
    objects = [compile_object(s, "\0".join(headers), CACHE, FLAGS) for s in sources]
    program = folder / "fuzz"
    command = [*compiler(), *FLAGS, *map(str, objects), "-lm", "-o", str(program)]
    subprocess.run(command, check=True)
    return program


def fuzz(fmu: Path, calls: int, seed: int = 1) -> subprocess.CompletedProcess[str]:
    """Run it; return code 0: nothing was found."""
    with tempfile.TemporaryDirectory() as folder:
        program = build(fmu, Path(folder))
        command = [str(program), str(seed), str(calls)]
        options = {**os.environ, "UBSAN_OPTIONS": "print_stacktrace=1"}
        return subprocess.run(command, capture_output=True, text=True, check=False, env=options)


def main(words: Sequence[str] | None = None) -> int:
    """Fuzz each FMU named; 1 when one is found wanting."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmus", nargs="+", type=Path)
    parser.add_argument("--calls", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args(words)
    worst = 0
    for fmu in given.fmus:
        done = fuzz(fmu, given.calls, given.seed)
        print(f"{fmu}: {done.stdout.strip()} {done.stderr[-3000:]}", flush=True)
        worst = max(worst, int(done.returncode != 0))
    return worst


if __name__ == "__main__":
    sys.exit(main())
