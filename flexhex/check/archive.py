"""What an FMU's archive holds: binaries where they belong, sources as listed, pages, pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePosixPath

from lxml import etree

from flexhex.check.subject import Subject

SUFFIXES = {"win": "dll", "windows": "dll", "linux": "so", "darwin": "dylib"}
MACHINES = {
    "linux64": (b"\x7fELF\x02", 18, b"\x3e\x00"),
    "linux32": (b"\x7fELF\x01", 18, b"\x03\x00"),
    "aarch64-linux": (b"\x7fELF\x02", 18, b"\xb7\x00"),
    "x86_64-linux": (b"\x7fELF\x02", 18, b"\x3e\x00"),
    "win64": (b"MZ", None, b"\x64\x86"),
    "win32": (b"MZ", None, b"\x4c\x01"),
    "darwin64": (b"", 0, b"\xcf\xfa\xed\xfe"),
}
"""Platform -> first bytes, where the machine stands (None: behind the PE mark), the machine."""
ROOTS = {"binaries", "sources", "resources", "documentation", "extra", "terminalsAndIcons"}
PNG = b"\x89PNG\r\n\x1a\n"


def archive(subject: Subject) -> Iterator[str]:
    """Complaints about the files of an FMU."""
    yield from _names(subject)
    yield from _binaries(subject)
    yield from _sources(subject)
    yield from _pages(subject)
    yield from _terminals(subject)


def _names(subject: Subject) -> Iterator[str]:
    seen: set[str] = set()
    for name in subject.names:
        if name in seen:
            yield f"{name} stands in the archive twice"
        seen.add(name)
    if subject.ours:
        known = {"modelDescription.xml", "model.png"}
        for name in subject.names:
            if name not in known and PurePosixPath(name).parts[0] not in ROOTS:
                yield f"{name} has no place in an FMU"


def _binaries(subject: Subject) -> Iterator[str]:
    places = {n.split("/")[1] for n in subject.names if n.startswith("binaries/")} - {""}
    identifiers = {
        str(e.get("modelIdentifier"))
        for tag in ("CoSimulation", "ModelExchange")
        for e in subject.root.iterfind(tag)
    }
    for platform in sorted(places):
        system = re.sub(r"[0-9]+$", "", platform.rpartition("-")[2] or platform)
        suffix = SUFFIXES.get(system)
        if suffix is None:
            yield f"binaries/{platform}: not the name of a platform"
            continue
        for identifier in sorted(identifiers):
            name = f"binaries/{platform}/{identifier}.{suffix}"
            if name not in subject.names:
                yield f"{name} is missing: the binary must be called as modelIdentifier says"
            elif not _is_of(subject.read(name), platform):
                yield f"{name} is no {platform} library"
    if not places and not any(n.startswith("sources/") for n in subject.names):
        yield "neither binaries nor sources: nothing can execute it"
    needs_tool = any(
        e.get("needsExecutionTool") == "true" for e in subject.root.iterfind("CoSimulation")
    )
    if subject.ours and (not places or needs_tool):
        yield "an FMU of flexhex brings a binary and needs no tool to execute"


def _is_of(data: bytes, platform: str) -> bool:
    """Whether a library is of that kind of machine; unknown platforms are believed."""
    if platform not in MACHINES:
        return True
    first, at, machine = MACHINES[platform]
    if at is None:
        at = int.from_bytes(data[0x3C:0x40], "little") + 4
    return data.startswith(first) and data[at : at + len(machine)] == machine


def _sources(subject: Subject) -> Iterator[str]:
    files = {n.removeprefix("sources/") for n in subject.names if n.startswith("sources/")}
    files = {n for n in files if n and not n.endswith("/")}
    listed = [
        str(e.get("name"))
        for tag in ("CoSimulation", "ModelExchange")
        for e in subject.root.iterfind(f"{tag}/SourceFiles/File")
    ]
    for name in sorted(set(listed) - files):
        yield f"sources/{name} is listed in SourceFiles but missing in the archive"
    code = {n: subject.read(f"sources/{n}") for n in files if n.endswith((".c", ".h", ".cpp"))}
    included = {
        PurePosixPath(m.decode()).name
        for text in code.values()
        for m in re.findall(rb'#\s*include\s*["<]([^">]+)[">]', text)
    }
    for name in sorted(n for n in files if n.endswith((".c", ".cpp")) and listed):
        if name not in listed and PurePosixPath(name).name not in included:
            yield f"sources/{name} is not listed in SourceFiles and included by no other"
    for name in sorted(
        included & {"flexhex_config.h", "model.h", "fmi.h", "block.h", "instance.h"}
    ):
        if subject.ours and name not in files:
            yield f"sources/{name} is included but missing in the archive"
    guid = str(subject.root.get("guid")).encode()
    if subject.ours and code and not any(guid in text for text in code.values()):
        yield f"sources/ are of another build: guid {guid.decode()} is in none of them"


def _pages(subject: Subject) -> Iterator[str]:
    pages = [n for n in subject.names if n.startswith("documentation/") and not n.endswith("/")]
    if (pages or subject.ours) and "documentation/index.html" not in pages:
        yield "documentation/index.html is missing: where importers open the documentation"
    if subject.ours and "documentation/licenses/license.txt" not in pages:
        yield "documentation/licenses/license.txt is missing: the licence of what is inside"
    for name in subject.names:
        if name == "model.png" or (name.startswith("terminalsAndIcons/") and name.endswith("png")):
            data = subject.read(name)
            if not data.startswith(PNG) or b"IEND" not in data[-12:]:
                yield f"{name} is no complete PNG picture"


def _terminals(subject: Subject) -> Iterator[str]:
    """Members of terminals are variables, once each in a terminal."""
    name = "terminalsAndIcons/terminalsAndIcons.xml"
    if name not in subject.names:
        return
    try:
        root = etree.fromstring(subject.read(name))
    except etree.XMLSyntaxError as error:
        yield f"{name}: {error}"
        return
    known = {v.name for v in subject.variables}
    for terminal in root.iter("Terminal"):
        members = [str(m.get("variableName")) for m in terminal.iterfind("TerminalMemberVariable")]
        for member in members:
            if member not in known:
                yield f"{name}: terminal {terminal.get('name')} has no variable {member}"
            elif members.count(member) > 1:
                yield f"{name}: terminal {terminal.get('name')} has {member} twice"
