"""One FMU: equations, interface and step.c in, `<identifier>.fmu` out."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import casadi as ca

from flexhex.fmugen import sources
from flexhex.fmugen.cmake import cmake_lists
from flexhex.fmugen.compile import HIDDEN, LOOPS, SMALL, compile_object, link_shared, strict
from flexhex.fmugen.description import model_description
from flexhex.fmugen.pack import write_zip
from flexhex.fmugen.page import page
from flexhex.fmugen.picture import picture
from flexhex.fmugen.platforms import PLATFORMS, host, tool
from flexhex.fmugen.recorded import recorded
from flexhex.fmugen.sources import Generated
from flexhex.fmugen.terminals import terminals
from flexhex.fmus.common.errors import BuildError
from flexhex.fmus.common.interface import Interface

RUNTIME = Path(__file__).parent.parent / "runtime"
FMI = RUNTIME / "fmi2"
"""The three headers of the standard, FMI 2.0.5."""
FMI_HEADERS = tuple(sorted(path.name for path in FMI.glob("*.h")))
CONFIG = "flexhex_config.h"
ANY = "any_fmu"
"""Identifier that the adapter's own objects are compiled for: one library holds one FMU, so all
FMUs share them."""
LICENSES = RUNTIME / "license.txt"
"""Of all that an archive holds."""


def build_fmu(
    interface: Interface,
    functions: Sequence[ca.Function] | Generated,
    step_c: Path,
    out_dir: Path,
    base_step: float = 0.00025,
    cache: Path | None = None,
    platforms: Sequence[str] = (),
    more: Mapping[str, str] | None = None,
) -> Path:
    """Generate, compile and pack an FMU; returns `out_dir/<interface.name>.fmu`.

    functions: the equations, or the C that was generated from them before. The headers in step_c's
    folder are included. Object files are kept in `cache` (default
    `out_dir/cache`), so an FMU that differs in start values alone compiles one table.
    platforms: for which computers, as in `flexhex.fmugen.platforms`; default: this one.
    more: further sources by file name, compiled along.
    Raises BuildError (compiler) or InterfaceError (units, names).
    """
    block, identifier = step_c.parent.name, interface.name
    texts = {**_runtime(), **(more or {})}
    for header in sorted(step_c.parent.glob("*.h")):
        texts[header.name] = header.read_text(encoding="utf-8")
    if isinstance(functions, Generated):
        generated = functions
    else:
        generated = Generated.of(interface, functions, block)
    texts[CONFIG] = sources.config(identifier)
    texts[f"{block}.h"] = generated.header
    texts[f"{identifier}_step.c"] = step_c.read_text(encoding="utf-8")
    if generated.source:
        texts[f"{identifier}_casadi.c"] = generated.source
    texts[f"{identifier}_fmu.c"] = sources.table(interface, base_step, "")
    guid = _guid(texts, model_description(interface, base_step, "", ()))
    texts[f"{identifier}_fmu.c"] = sources.table(interface, base_step, guid)

    units = sorted(name for name in texts if name.endswith(".c"))
    files = {f"sources/{name}": text.encode() for name, text in texts.items()}
    files["sources/CMakeLists.txt"] = cmake_lists(identifier, units).encode()
    files["modelDescription.xml"] = model_description(interface, base_step, guid, units)
    for name in platforms or (host(),):
        place = f"binaries/{name}/{identifier}.{PLATFORMS[name].suffix}"
        files[place] = _compile(texts, units, identifier, cache or out_dir / "cache", name)
        if name == host():
            files |= _results(interface, files[place], guid)
    readme = step_c.with_name("README.md")
    about = readme.read_text(encoding="utf-8") if readme.exists() else ""
    text = page(interface, generated.operations, block, base_step, about)
    files["documentation/index.html"] = text.encode()
    files["documentation/licenses/license.txt"] = LICENSES.read_bytes()
    files["model.png"] = picture(interface)
    files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals(interface)
    return write_zip(out_dir / f"{identifier}.fmu", files)


def _results(interface: Interface, binary: bytes, guid: str) -> dict[str, bytes]:
    """What the binary answers, from a place of its own: a library is loaded once for each path."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / interface.name
        library.write_bytes(binary)
        return recorded(interface, library, guid)


def _runtime() -> dict[str, str]:
    """The adapter, each C file with the FMU's identity in front; FMI's own headers."""
    texts = {}
    for path in sorted(RUNTIME.glob("*.[ch]")):
        text = path.read_text(encoding="utf-8")
        texts[path.name] = f'#include "{CONFIG}"\n{text}' if path.suffix == ".c" else text
    for name in FMI_HEADERS:
        texts[name] = (FMI / name).read_text(encoding="utf-8")
    return texts


def _guid(texts: dict[str, str], description: bytes) -> str:
    digest = hashlib.sha256(description)
    for name in sorted(texts):
        digest.update(f"{name}\0{texts[name]}\0".encode())
    h = digest.hexdigest()
    return "{" + "-".join([h[:8], h[8:12], h[12:16], h[16:20], h[20:32]]) + "}"


def _compile(
    texts: dict[str, str], units: Sequence[str], identifier: str, cache: Path, platform: str
) -> bytes:
    generator, adapter = tool(platform), {**_runtime(), CONFIG: sources.config(ANY)}
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=cache) as folder:
        work = Path(folder)
        shared = work / "shared"
        for place, written in ((work, texts), (shared, adapter)):
            place.mkdir(exist_ok=True)
            for name, text in written.items():
                (place / name).write_text(text, encoding="utf-8")
        headers, of_adapter = _headers(texts), _headers(adapter)

        def compiled(name: str) -> Path:
            warned = (*HIDDEN, *LOOPS, *strict())
            if name in adapter:
                return compile_object(shared / name, of_adapter, cache, warned, generator)
            if name.endswith("_casadi.c"):
                # generated equations include nothing of ours: their object outlives header changes
                return compile_object(work / name, "", cache, (*HIDDEN, *SMALL), generator)
            table = (f"-D{identifier}_fmu={ANY}_fmu",) if name.endswith("_fmu.c") else ()
            return compile_object(work / name, headers, cache, (*warned, *table), generator)

        library = work / f"{identifier}.{PLATFORMS[platform].suffix}"
        objects = [compiled(name) for name in units]
        try:
            return link_shared(objects, library, tool=generator).read_bytes()
        except BuildError:
            # a damaged file in the cache would stop every later build: once more without it
            for path in objects:
                path.unlink(missing_ok=True)
            objects = [compiled(name) for name in units]
            return link_shared(objects, library, tool=generator).read_bytes()


def _headers(texts: Mapping[str, str]) -> str:
    """Hash of all headers."""
    listed = "\0".join(texts[name] for name in sorted(texts) if name.endswith(".h"))
    return hashlib.sha256(listed.encode()).hexdigest()
