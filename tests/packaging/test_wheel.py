"""Wheel and sdist: what they hold, and that the installed wheel works in an empty folder."""

from __future__ import annotations

import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.packaging.conftest import Installed, run
from tests.test_house import PACKAGES, tracked

LINKED = {**PACKAGES, "flexhex.runtime": "build/runtime", "flexhex.machines": "machines"}


def contents(wheel: Path) -> dict[str, bytes]:
    """Files of a wheel by name."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def expected() -> dict[str, Path]:
    """Every file under version control in the package's folders, by its name in the wheel."""
    files = {}
    for package, folder in LINKED.items():
        for path in tracked():
            if path.is_relative_to(ROOT / folder):
                inside = path.relative_to(ROOT / folder).as_posix()
                files[f"{package.replace('.', '/')}/{inside}"] = path
    return files


def test_wheel_holds_the_package_and_nothing_else(dist: Path) -> None:
    (wheel,) = dist.glob("*.whl")
    result = contents(wheel)
    tops = {name.split("/")[0] for name in result}
    assert tops == {"flexhex", wheel.name.rsplit("-", 3)[0] + ".dist-info"}
    inside = {name: data for name, data in result.items() if name.startswith("flexhex/")}
    files = expected()
    assert sorted(inside) == sorted(files)
    assert all(data == files[name].read_bytes() for name, data in inside.items())
    assert f"{min(tops - {'flexhex'})}/licenses/LICENSE" in result


def test_sdist_holds_every_file_once_and_builds_the_same_wheel(dist: Path, tmp_path: Path) -> None:
    (sdist,), (wheel,) = dist.glob("*.tar.gz"), dist.glob("*.whl")
    with tarfile.open(sdist) as archive:
        members = archive.getmembers()
    assert all(member.isfile() for member in members), "no links"
    inside = sorted(m.name.split("/", 1)[1] for m in members)
    assert [name for name in inside if name.startswith("flexhex/")] == sorted(expected())
    assert {n.split("/")[0] for n in inside} <= {
        "flexhex", "README.md", "LICENSE", "pyproject.toml", "PKG-INFO", ".gitignore"
    }  # fmt: skip
    pip = (sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-index")
    run(*pip, "--no-build-isolation", "-w", tmp_path, sdist, cwd=tmp_path)
    (again,) = tmp_path.glob("*.whl")
    assert contents(again) == contents(wheel)


def test_installing_adds_one_package(installed: Installed) -> None:
    added = {path.name for path in installed.site.iterdir()} - installed.before
    assert sorted(name.split("-")[0] for name in added) == ["flexhex", "flexhex"]
    assert "flexhex" in added


def test_installed_package_is_the_one_that_runs(installed: Installed, tmp_path: Path) -> None:
    code = "import flexhex, flexhex.cli, flexhex.fmus.plant; print(flexhex.fmus.plant.__file__)"
    where = Path(installed.run("python", "-I", "-c", code, cwd=tmp_path).strip())
    assert where.is_relative_to(installed.site)


@pytest.mark.usefixtures("builder")
def test_installed_wheel_runs_in_an_empty_folder(installed: Installed, tmp_path: Path) -> None:
    """Its FMUs come out of the cache that the other tests of this session fill."""
    printed = installed.run("flexhex", "run", "--quick", cwd=tmp_path)
    for row in ("feedback only", "fixed feedforward", "adaptive feedforward"):
        assert row in printed
    assert "</html>" in (tmp_path / "out" / "quick" / "report.html").read_text(encoding="utf-8")
    assert (tmp_path / "out" / "quick" / "runs" / "adaptive.h5").is_file()
