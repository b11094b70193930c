"""For which computers an FMU is compiled: folder in the archive, compiler, flags."""

from __future__ import annotations

import importlib.util
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from flexhex.fmugen.compile import LINK, LOOPS, STRICT, Tool, own
from flexhex.fmus.common.errors import BuildError, UsageError

MINGW = "x86_64-w64-mingw32-gcc"
ZIG = (sys.executable, "-m", "ziglang", "cc")
QUIET = ("-fno-sanitize=undefined", "-Wno-unused-command-line-argument")
"""For zig, which is for debugging unless told otherwise."""


@dataclass(frozen=True)
class Platform:
    """One folder of `binaries/`: the library's suffix and what zig calls the computer."""

    name: str
    suffix: str
    target: str


PLATFORMS = {
    p.name: p
    for p in (
        Platform("linux64", "so", "x86_64-linux-gnu.2.17"),
        Platform("win64", "dll", "x86_64-windows-gnu"),
        Platform("aarch64-linux", "so", "aarch64-linux-gnu.2.17"),
        Platform("darwin64", "dylib", "x86_64-macos"),
    )
}


def host() -> str:
    """Name of this computer's platform; BuildError where there is none."""
    arm = platform.machine() in ("aarch64", "arm64")
    names = {"Linux": "aarch64-linux" if arm else "linux64", "Darwin": "darwin64"}
    if platform.system() not in names:
        raise BuildError(f"FMUs are built on Linux or macOS, not on {platform.system()}")
    return names[platform.system()]


def wanted(text: str) -> tuple[str, ...]:
    """Platforms named in a list such as `linux64,win64`; UsageError for an unknown one."""
    names = tuple(dict.fromkeys(word.strip() for word in text.split(",") if word.strip()))
    for name in names:
        if name not in PLATFORMS:
            raise UsageError(f"unknown platform {name!r}; there are {', '.join(PLATFORMS)}")
    if not names:
        raise UsageError(f"no platform named; there are {', '.join(PLATFORMS)}")
    return names


def tool(name: str) -> Tool:
    """Compiler for a platform: the system's own, mingw-w64, or zig for the rest.

    Raises BuildError that says what to install.
    """
    if name == host():
        return own()
    if name == "win64" and shutil.which(MINGW):
        link = ("-shared", "-s", "-static-libgcc", "-Wl,--no-insert-timestamp")
        flags = ("-std=c99", "-O2", "-ffp-contract=off")
        return Tool((MINGW,), _version((MINGW,)), flags, link, without=STRICT)
    if importlib.util.find_spec("ziglang") is None:
        more = f"{MINGW} (Debian: mingw-w64) or " if name == "win64" else ""
        raise BuildError(f"{name} needs {more}zig: pip install 'flexhex[platforms]'")
    target = PLATFORMS[name].target
    command = (*ZIG, "-target", target, *QUIET)
    pic = () if "windows" in target else ("-fPIC",)
    plain = "macos" in target or "windows" in target
    flags = ("-std=c99", "-O2", "-ffp-contract=off", *pic)
    shared = LINK if not plain else ("-shared", "-s")
    # its warnings are not those that the sources are kept free of
    return Tool(command, _version(ZIG), flags, shared, without=(*LOOPS, *STRICT))


@lru_cache
def _version(command: Sequence[str]) -> str:
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    return (done.stdout.splitlines() or ["?"])[0]
