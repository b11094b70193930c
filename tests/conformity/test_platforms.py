"""Binaries for other computers answer as this computer's own, on the golden inputs.

win64 runs under Wine, aarch64-linux under qemu-user; what is not installed is skipped by name.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from flexhex.check.fmu import check_fmu
from flexhex.fmugen.blocks import build_block
from flexhex.fmugen.platforms import MINGW, PLATFORMS, host, tool, wanted
from flexhex.fmus.common.errors import BuildError, UsageError
from flexhex.fmus.common.machine.machine import Machine
from tests.adapter import toys
from tests.conftest import OBJECTS
from tests.golden.golden import FOLDER, read
from tests.golden.test_golden import RECORDED

HERE = Path(__file__).parent
WINE = shutil.which("wine64") or shutil.which("wine64", path="/usr/lib/wine")
QEMU = shutil.which("qemu-aarch64")
RUN: dict[str, list[str | None]] = {
    "linux64": [],
    "win64": [WINE],
    "aarch64-linux": [QEMU, "-L", "/usr/aarch64-linux-gnu"],
}

LAST_BIT = {("filter", "win64")}
"""Where the platform's C library rounds sin and cos otherwise: one value in a thousand."""


def able(platform: str) -> None:
    """Skip unless this computer can build for the platform and run the result."""
    try:
        tool(platform)
    except BuildError as error:
        pytest.skip(str(error))
    if None in RUN[platform]:
        pytest.skip(f"{'Wine' if platform == 'win64' else 'qemu-aarch64'} is not installed")


def table(folder: Path, name: str) -> str:
    """The golden inputs of an FMU in the form that vectors.c reads."""
    root = etree.parse(str(folder / "modelDescription.xml")).getroot()
    variables = {v.get("name"): v for v in root.iter("ScalarVariable")}
    names, rows = read(FOLDER / f"{name}.in.csv")
    inputs = [variables[n].get("valueReference") for n in names]
    outputs = [v for v in variables.values() if v.get("causality") == "output"]
    Ts = float(variables["Ts"].find("Real").get("start"))
    words = [root.get("guid"), len(inputs), *inputs]
    for tags in (("Real",), ("Integer", "Enumeration"), ("Boolean",)):
        references = [v.get("valueReference") for v in outputs if v[0].tag in tags]
        words += [len(references), *references]
    words += [bits(RECORDED[name][3] * Ts), len(rows)]
    words += [bits(value) for row in rows for value in row]
    return "\n".join(map(str, words)) + "\n"


def bits(value: float) -> str:
    return f"{struct.unpack('<Q', struct.pack('<d', value))[0]:x}"


def answers(folder: Path, name: str, platform: str) -> np.ndarray:
    """Outputs of the platform's binary, run here."""
    compiler, sources = tool(platform), folder / "sources"
    program = folder / f"vectors-{platform}.exe"
    libraries = [] if platform == "win64" else ["-ldl"]
    command = [*compiler.command, *compiler.flags, f"-I{sources}", str(HERE / "vectors.c")]
    run([*command, "-o", str(program), *libraries], folder)
    (folder / "table.txt").write_text(table(folder, name))
    library = f"binaries/{platform}/{name}.{PLATFORMS[platform].suffix}"
    said = run([*RUN[platform], f"./{program.name}", library, "table.txt"], folder)
    numbers = [int(line, 16) for line in said.split()]
    return np.array(struct.unpack(f"<{len(numbers)}d", struct.pack(f"<{len(numbers)}Q", *numbers)))


def run(command: Sequence[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.stdout[-500:] + done.stderr)[-3000:]
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("platform", ["win64", "aarch64-linux"])
@pytest.mark.parametrize("name", RECORDED)
def test_other_computers_answer_alike(
    machine: Machine, tmp_path: Path, name: str, platform: str
) -> None:
    able(platform)
    fmu = build_block(name, machine, tmp_path, cache=OBJECTS, platforms=(host(), platform))
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    ours, theirs = answers(folder, name, host()), answers(folder, name, platform)
    assert ours.shape == theirs.shape
    assert np.isfinite(theirs).all()
    worst = np.max(np.abs(ours - theirs))
    print(f"{name} {platform}: {np.mean(ours == theirs):.1%} equal bits, worst {worst:.2g}")
    if (name, platform) in LAST_BIT:
        # cos and sin of up to 324 times the angle, as they are: 2^-53 is the last bit below one
        assert worst <= 2.0**-53
        return
    assert np.array_equal(ours, theirs)


@pytest.mark.slow
@pytest.mark.parametrize("platform", PLATFORMS)
def test_binary_of_each_platform_is_of_its_kind(tmp_path: Path, platform: str) -> None:
    try:
        tool(platform)
    except BuildError as error:
        pytest.skip(str(error))
    interface, functions = toys.interface(), toys.functions()
    from flexhex.fmugen.fmu import build_fmu

    written = [
        build_fmu(interface, functions, toys.STEP_C, tmp_path / k, platforms=(host(), platform))
        for k in ("one", "two")
    ]
    assert check_fmu(written[0]) == []
    assert written[0].read_bytes() == written[1].read_bytes(), "not reproducible"


def test_unknown_platform_is_refused() -> None:
    with pytest.raises(UsageError, match="unknown platform 'amiga'; there are linux64, win64"):
        wanted("linux64,amiga")
    assert wanted("win64, linux64,win64") == ("win64", "linux64")


def test_missing_compiler_for_a_platform_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(BuildError, match=f"win64 needs {MINGW} .* or zig: pip install"):
        tool("win64")
    with pytest.raises(BuildError, match="darwin64 needs zig"):
        tool("darwin64")
