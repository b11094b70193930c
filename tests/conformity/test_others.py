"""FMUs of other makers, from packages that bring them along: what is well is not blamed.

Each package is optional: `pip install pythonfmu unifmu fmu-manipulation-toolbox`.
"""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from flexhex.check.fmu import check_fmu

pytestmark = pytest.mark.slow
GAIN = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Gain(Fmi2Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.u, self.y = 1.0, 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, size):
        self.y = 2 * self.u
        return True
"""
# mistakes that these FMUs do have, as the standard is written
KNOWN = {
    "pythonfmu": {"ModelStructure/InitialUnknowns does not contain the expected set"},
    "toolbox": {
        # the embedded FMUs' names have a hyphen; the container hands its callbacks on to them
        "is not a legal variable name for naming convention",
        "more of this kind",
        "canNotUseMemoryManagementFunctions is true, but it uses them",
    },
}


def run(folder: Path, *command: str) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


def unexplained(path: Path, known: set[str]) -> list[str]:
    """Complaints that are no known mistake."""
    return [text for text in check_fmu(path) if not any(part in text for part in known)]


def test_fmu_of_pythonfmu(tmp_path: Path) -> None:
    pytest.importorskip("pythonfmu")
    (tmp_path / "gain.py").write_text(GAIN)
    run(tmp_path, sys.executable, "-m", "pythonfmu", "build", "-f", "gain.py")
    assert unexplained(tmp_path / "Gain.fmu", KNOWN["pythonfmu"]) == []


def test_fmu_of_unifmu(tmp_path: Path) -> None:
    package = pytest.importorskip("unifmu")
    common = Path(package.__file__).parent / "resources" / "common"
    (tmp_path / "fmu").mkdir()
    shutil.copyfile(common / "modelDescription.xml", tmp_path / "fmu" / "modelDescription.xml")
    shutil.copytree(common / "unifmu_binaries", tmp_path / "fmu" / "binaries")
    packed = Path(shutil.make_archive(str(tmp_path / "unifmu"), "zip", tmp_path / "fmu"))
    assert unexplained(packed.rename(tmp_path / "unifmu.fmu"), set()) == []


def test_container_of_the_toolbox(tmp_path: Path, hexapod_ssp: Path) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    importlib.import_module("xmlschema")
    shutil.copyfile(hexapod_ssp, tmp_path / "hexapod.ssp")
    module = "fmu_manipulation_toolbox.cli.fmucontainer"
    code = f"from {module} import fmucontainer; fmucontainer()"
    run(tmp_path, sys.executable, "-c", code, "-container", "hexapod.ssp:0.00025")
    assert unexplained(tmp_path / "hexapod.fmu", KNOWN["toolbox"]) == []
