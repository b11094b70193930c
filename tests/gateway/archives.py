"""Modified copies of .ssp and .fmu files, for tests of refusals and faults."""

from __future__ import annotations

import io
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile

from flexhex.fmugen.compile import STRICT, compiler
from flexhex.fmugen.fmu import FMI
from flexhex.ssp.fmu import binary_path
from flexhex.ssp.read import read_ssp

PROXY = Path(__file__).with_name("proxy.c")
Changes = Mapping[str, bytes | None]


def changed(archive: bytes, changes: Changes) -> bytes:
    """A zip archive with members replaced, added or (None) left out."""
    out = io.BytesIO()
    with ZipFile(io.BytesIO(archive)) as old, ZipFile(out, "w") as new:
        for name in old.namelist():
            if name not in changes:
                new.writestr(name, old.read(name))
        for name, data in changes.items():
            if data is not None:
                new.writestr(name, data)
    return out.getvalue()


def member(archive: bytes, name: str) -> bytes:
    """One file of a zip archive."""
    with ZipFile(io.BytesIO(archive)) as opened:
        return opened.read(name)


def with_fmu(ssp: bytes, source: str, changes: Changes) -> bytes:
    """A .ssp with members of one of its FMUs changed."""
    return changed(ssp, {source: changed(member(ssp, source), changes)})


@dataclass(frozen=True)
class Spoil:
    """What the proxy does to one instance, from its step `step` on for `count` steps.

    The gateway's own instances beside those of the run have a suffix: "F-model".

    Step k goes from k to k + 1 sample times. kind: "set" (the output `variable` shows `value`,
    which may be nan), "error" (fmi2DoStep returns fmi2Error), "sleep" (it takes `value` [s] more),
    "hang" (it says so on stderr and never returns; at step -1 its initialisation does), "crash"
    (SIGABRT); "instantiate", "get", "put", "terminate", "free" (that call never returns).
    """

    instance: str
    step: int
    kind: str
    variable: str = ""
    value: float = 0.0
    count: int = 1


def spoiled(ssp: Path, spoil: Spoil, out: Path) -> Path:
    """Writes `out`, the .ssp with the FMU of one instance behind the proxy, and returns it."""
    instance = read_ssp(ssp).instance(spoil.instance.partition("-")[0])
    variables = instance.fmu.variables
    reference = variables[spoil.variable].reference if spoil.variable else 0
    words = (spoil.instance, spoil.step, spoil.count, spoil.kind, reference, spoil.value)
    binary, data = binary_path(instance.fmu.model), ssp.read_bytes()
    changes = {
        binary: shared_library(PROXY, out.parent).read_bytes(),
        "resources/real.so": member(member(data, instance.source), binary),
        "resources/proxy.txt": " ".join(map(str, words)).encode(),
    }
    out.write_bytes(with_fmu(data, instance.source, changes))
    return out


def shared_library(source: Path, folder: Path) -> Path:
    """A C file compiled to a shared library in `folder`, once."""
    library = folder / f"{source.stem}.so"
    if not library.exists():
        flags = ("-std=c99", "-O1", "-fPIC", "-shared", *STRICT, f"-I{FMI}")
        subprocess.run([*compiler(), *flags, str(source), "-o", str(library), "-ldl"], check=True)
    return library


def edited(ssp: bytes, name: str, *pairs: tuple[str, str]) -> bytes:
    """A .ssp with text replaced in one of its files; each text must be there."""
    text = member(ssp, name).decode()
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    return changed(ssp, {name: text.encode()})


def wire(start: str, end: str) -> str:
    """A connection as the .ssp writes it."""
    (a, x), (b, y) = start.split(".", 1), end.split(".", 1)
    ends = f'startElement="{a}" startConnector="{x}" endElement="{b}" endConnector="{y}"'
    return f"<ssd:Connection {ends}"
