"""Validators of others are silent about all FMUs (FMPy's runs inside `flexhex check`).

VDMCheck2: `mvn dependency:get -Dartifact=org.into-cps.vdmcheck.fmi2:vdmcheck2:1.1.3`.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from lxml import etree

from flexhex.fmugen.blocks import BLOCKS

pytestmark = pytest.mark.slow
NAMES = (*BLOCKS, "machine")
REPOSITORY = Path.home() / ".m2" / "repository"
VERSION = "1.1.3"


@pytest.fixture(scope="module")
def vdmcheck(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """VDMCheck2 laid out as in its own release: jars side by side, models unpacked."""
    if not shutil.which("java"):
        pytest.skip("Java is not installed")
    folder = tmp_path_factory.mktemp("vdmcheck")
    for name in ("vdmj", "annotations", "xsd2vdm", "fmuReader", "vdmcheck2", "static-model",
                 "rule-model"):  # fmt: skip
        listed = [p for p in REPOSITORY.rglob(f"{name}-*.jar") if "sources" not in p.name]
        if not listed:
            pytest.skip(f"VDMCheck2 is not in the local Maven repository ({name})")
        if name.endswith("-model") or name == "vdmcheck2":
            with zipfile.ZipFile(listed[-1]) as archive:
                wanted = [n for n in archive.namelist() if n.startswith(("fmi2-", "fmi2schema/"))]
                archive.extractall(folder, wanted)
        shutil.copyfile(listed[-1], folder / f"{name}.jar")
    return folder / "vdmcheck2.jar"


def says(vdmcheck: Path, fmu: Path) -> str:
    command = ["java", "-jar", str(vdmcheck), str(fmu)]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


@pytest.mark.parametrize("name", NAMES)
def test_vdmcheck_finds_nothing(vdmcheck: Path, fmu_dir: Path, name: str) -> None:
    assert says(vdmcheck, fmu_dir / f"{name}.fmu") == "No errors found."


def test_vdmcheck_would_notice(vdmcheck: Path, fmu_dir: Path, tmp_path: Path) -> None:
    broken = tmp_path / "feedback.fmu"
    with zipfile.ZipFile(fmu_dir / "feedback.fmu") as old, zipfile.ZipFile(broken, "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b'initial="calculated"', b'initial="exact"'))
    assert says(vdmcheck, broken) != "No errors found."


@pytest.mark.parametrize("name", NAMES)
def test_toolbox_finds_nothing(fmu_dir: Path, name: str) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    code = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"
    command = [sys.executable, "-c", code, "-input", str(fmu_dir / f"{name}.fmu"), "-check"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said[-2000:]
    assert "compliant with FMI-2.0" in said
    assert "No semantic error" in said
    assert "ERROR" not in said
    assert "WARNING" not in said


@pytest.mark.parametrize("name", NAMES)
def test_terminals_are_valid(fmu_dir: Path, name: str) -> None:
    import fmpy

    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    with zipfile.ZipFile(fmu_dir / f"{name}.fmu") as archive:
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    etree.XMLSchema(etree.parse(str(schema))).assertValid(root)
    arrays = {v.get("name") for v in root.iter("Terminal")}
    assert arrays & {"theta", "r", "tau", "tau_ff", "p", "theta_f", "x"}
