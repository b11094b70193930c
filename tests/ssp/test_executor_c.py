"""The C executor without Python: a host component, and nothing leaks (address sanitizer)."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import pytest

from flexhex.fmugen.compile import STRICT, compiler
from flexhex.fmugen.fmu import FMI
from flexhex.ssp.fmu import binary_path, read_fmu
from flexhex.ssp.library import HERE

SANITIZE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@pytest.fixture(scope="session")
def harness(work: Path) -> Path:
    """The test program, with sanitizers where the compiler has them."""
    program = work / "harness"
    source = Path(__file__).with_name("harness.c")
    command = [*compiler(), "-std=c99", "-g", *STRICT, f"-I{FMI}", f"-I{HERE}"]
    files = [str(source), str(HERE / "executor.c"), "-o", str(program), "-ldl", "-lm"]
    sanitized = subprocess.run([*command, *SANITIZE, *files], check=False, capture_output=True)
    if sanitized.returncode:
        subprocess.run([*command, *files], check=True)
    return program


@pytest.fixture(scope="session")
def relays(ring_ssp: Path, narrow_ssp: Path, work: Path) -> dict[int, list[str]]:
    """Library and GUID of relays by period; that of period 4 refuses stamps beyond 40."""
    matches = {}
    for steps, name, folder in ((2, "relay2", work), (4, "relay_narrow", work / "narrow")):
        file = folder / f"{name}.fmu"
        with zipfile.ZipFile(file) as archive:
            library = archive.extract(binary_path(name), work / "loose" / name)
        guid = read_fmu(file.read_bytes(), file.name).guid
        matches[steps] = [library, guid, str(steps)]
    return matches


def drive(harness: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([harness, *arguments], check=False, capture_output=True, text=True)


@pytest.mark.parametrize("how", [[], ["play"]])
def test_host_component_feeds_the_bus(
    harness: Path, relays: dict[int, list[str]], how: list[str]
) -> None:
    done = drive(harness, *relays[2], "24", *how)
    assert (done.returncode, done.stderr) == (0, "")
    # row k is what the relay sampled at 2 (k - 1); nothing is sampled at 0
    stamps = [-1.0, -1.0, *(float(n) for n in range(2, 24, 2))]
    assert [float(s) for s in done.stdout.splitlines()[0].split()] == stamps
    assert done.stdout.splitlines()[1] == "now 24, 12 steps"


def test_failure_leaks_nothing(harness: Path, relays: dict[int, list[str]]) -> None:
    done = drive(harness, *relays[4], "240")
    assert (done.returncode, done.stderr) == (1, "")
    # ten stamps a base step: the sample at n = 8 is the first beyond 40
    assert done.stdout.startswith("relay: fmi2SetReal of inputs at t = 0.002 s returned fmi2Error")


def test_wrong_guid_and_missing_library_leak_nothing(
    harness: Path, relays: dict[int, list[str]]
) -> None:
    library, _, steps = relays[2]
    done = drive(harness, library, "{wrong}", steps, "24")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("relay: fmi2Instantiate at t = 0 s returned fmi2Error: ")
    done = drive(harness, "/nowhere.so", "{wrong}", steps, "24")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("relay: its library does not load: /nowhere.so")
