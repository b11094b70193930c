"""FMUs of other makers, from packages that bring them along: exactly their mistakes are found.

Each package is optional: `pip install pythonfmu unifmu fmu-manipulation-toolbox`.
"""

from __future__ import annotations

import importlib
import os
import re
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


def run(folder: Path, *command: str) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


def kinds(path: Path) -> set[str]:
    """What is said about an FMU, without variables and places: its kinds of mistakes."""
    kinds_of_mistakes = set()
    for text in check_fmu(path):
        plain = re.sub(r"^'[^']*'", "NAME", text.removeprefix(f"{path}: "))
        kinds_of_mistakes.add(re.sub(r"\{.*|\. No terminal.*|^\.\.\. and .*", "", plain).strip())
    return kinds_of_mistakes - {""}


def test_fmu_of_pythonfmu_lacks_its_initial_unknowns(tmp_path: Path) -> None:
    pytest.importorskip("pythonfmu")
    (tmp_path / "gain.py").write_text(GAIN)
    run(tmp_path, sys.executable, "-m", "pythonfmu", "build", "-f", "gain.py")
    # true: y is calculated (the default of an output), so InitialUnknowns must list it
    assert kinds(tmp_path / "Gain.fmu") == {
        "ModelStructure/InitialUnknowns does not contain the expected set of variables. Expected"
    }


def test_fmu_of_unifmu_is_not_blamed(tmp_path: Path) -> None:
    package = pytest.importorskip("unifmu")
    common = Path(package.__file__).parent / "resources" / "common"
    (tmp_path / "fmu").mkdir()
    shutil.copyfile(common / "modelDescription.xml", tmp_path / "fmu" / "modelDescription.xml")
    shutil.copytree(common / "unifmu_binaries", tmp_path / "fmu" / "binaries")
    packed = Path(shutil.make_archive(str(tmp_path / "unifmu"), "zip", tmp_path / "fmu"))
    assert check_fmu(packed.rename(tmp_path / "unifmu.fmu")) == []


def test_reference_fmus_are_not_blamed() -> None:
    """The Modelica Association's own, which no package brings along."""
    folder = os.environ.get("FLEXHEX_REFERENCE_FMUS")
    if folder is None:
        pytest.skip(
            "FLEXHEX_REFERENCE_FMUS=<folder of .fmu> is not set: git clone"
            " https://github.com/modelica/Reference-FMUs, cmake -S . -B b -DFMI_VERSION=2"
            " -DWITH_FMUSIM=OFF, cmake --build b; the folder is b/fmus"
        )
    paths = sorted(Path(folder).glob("*.fmu"))
    assert len(paths) >= 6
    assert [text for path in paths for text in check_fmu(path)] == []


def test_container_of_the_toolbox_has_two_mistakes(tmp_path: Path, hexapod_ssp: Path) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    importlib.import_module("xmlschema")
    shutil.copyfile(hexapod_ssp, tmp_path / "hexapod.ssp")
    module = "fmu_manipulation_toolbox.cli.fmucontainer"
    code = f"from {module} import fmucontainer; fmucontainer()"
    run(tmp_path, sys.executable, "-c", code, "-container", "hexapod.ssp:0.00025")
    assert kinds(tmp_path / "hexapod.fmu") == {
        # true: it says `structured`, but calls a second FMU of one kind `kinematics-1`
        "NAME is no structured name like arm[3].lam or der(x)",
        # true: it hands the importer's functions on to the FMUs inside, which use them
        "binary: canNotUseMemoryManagementFunctions is true, but it uses them",
    }
