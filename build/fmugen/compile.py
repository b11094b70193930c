"""The C compiler: object files kept by content, one shared library a call."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

from flexhex.fmugen.pack import scratch_file
from flexhex.fmus.common.errors import BuildError

FLAGS = ("-std=c99", "-O2", "-fPIC", "-ffp-contract=off")
HIDDEN = ("-fvisibility=hidden",)
WERROR = "FLEXHEX_WERROR"
"""Environment variable: 1 makes every warning of the compiler an error, as our own tests do."""
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Werror")
LOOPS = ("-ftree-vectorize", "-fpeel-loops")
"""For hand-written C: the loops of filter and estimator gain from both, and lose by -O3."""
SMALL = ("-Os", "-fno-math-errno")
"""For generated code: straight lines that hardly fit in the instruction cache, roots without
their error report; the same bits as without either."""
LINK = ("-shared", "-s", "-Wl,--build-id=none", "-Wl,-z,noexecstack")


@dataclass(frozen=True)
class Tool:
    """A compiler: its command and version, flags to compile and to link, flags it does not know."""

    command: tuple[str, ...]
    version: str
    flags: tuple[str, ...] = FLAGS
    link: tuple[str, ...] = LINK
    without: tuple[str, ...] = ()


def strict() -> tuple[str, ...]:
    """STRICT when FLEXHEX_WERROR=1, else nothing.

    A newer compiler may warn of something new: this must not stop a user's build.
    """
    return STRICT if os.environ.get(WERROR) == "1" else ()


@lru_cache
def compiler() -> tuple[str, ...]:
    """The command: $CC, or cc, gcc, clang, whichever is found first.

    Raises BuildError when there is none.
    """
    named = os.environ.get("CC")
    for candidate in [named] if named else ["cc", "gcc", "clang"]:
        words = tuple(shlex.split(candidate))
        if words and shutil.which(words[0]):
            return words
    missing = f"$CC = {named!r}" if named else "cc, gcc or clang"
    raise BuildError(f"no C compiler: {missing} is not on the PATH; install gcc or set CC")


@lru_cache
def version() -> str:
    """First line of the compiler's own version text."""
    return _run([*compiler(), "--version"]).splitlines()[0]


def own() -> Tool:
    """This computer's own compiler."""
    return Tool(compiler(), version())


def compile_object(
    source: Path,
    headers: str,
    cache: Path,
    flags: Sequence[str] = (),
    tool: Tool | None = None,
) -> Path:
    """Object file of a C source; headers: hash of all that it may include.

    tool: another compiler than this computer's own.
    """
    tool = tool or own()
    command = [*tool.command, *tool.flags, *(f for f in flags if f not in tool.without)]
    key = hashlib.sha256(
        "\0".join([tool.version, *command, headers, source.read_text(encoding="utf-8")]).encode()
    ).hexdigest()[:24]
    target = cache / f"{source.stem}-{key}.o"
    try:
        os.utime(target)
    except OSError:
        cache.mkdir(parents=True, exist_ok=True)
        scratch = scratch_file(target)
        # run inside the folder: no path of this machine reaches the object
        _run([*command, "-c", source.name, "-o", str(scratch.resolve())], source.parent)
        scratch.replace(target)
    return target


def link_shared(
    objects: Sequence[Path],
    target: Path,
    libraries: Sequence[str] = ("-lm",),
    tool: Tool | None = None,
) -> Path:
    """Shared library of objects, without debug data or build identifiers."""
    target.parent.mkdir(parents=True, exist_ok=True)
    tool = tool or own()
    name = (f"-Wl,-install_name,@rpath/{target.name}",) if target.suffix == ".dylib" else ()
    whole = [str(path.resolve()) for path in objects]
    # linkers write the name of what they make into it: so it has its own name from the start
    with TemporaryDirectory(dir=target.parent, prefix=f".{target.name}.") as scratch:
        command = [*tool.command, *tool.link, *name, "-o", target.name, *whole, *libraries]
        _run(command, Path(scratch))
        (Path(scratch) / target.name).replace(target)
    return target


def _run(command: Sequence[str], folder: Path | None = None) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.strip()][:12]
        raise BuildError(f"{shlex.join(command)} failed:\n" + "\n".join(lines))
    return done.stdout
