"""The package as users get it: wheel and sdist, and an environment with the wheel alone."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.conftest import ROOT


def run(*command: str | Path, cwd: Path, **environment: str) -> str:
    """What a command prints; AssertionError with its messages when it fails."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
        env=environment or None,
    )
    assert done.returncode == 0, f"{command}: {done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


@dataclass(frozen=True)
class Installed:
    """A virtual environment with the wheel and its runtime dependencies, and nothing else."""

    folder: Path
    site: Path
    before: frozenset[str]

    def run(self, *command: str | Path, cwd: Path) -> str:
        """Run a program of the environment, unaware of the checkout and of this environment."""
        kept = {k: os.environ[k] for k in ("FLEXHEX_CACHE", "FLEXHEX_WERROR") if k in os.environ}
        program = self.folder / "bin" / str(command[0])
        return run(program, *command[1:], cwd=cwd, PATH="/usr/bin:/bin", HOME=str(cwd), **kept)


@pytest.fixture(scope="session")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the wheel and the sdist of this checkout."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "hatchling", "build", "-d", folder, cwd=ROOT)
    return folder


@pytest.fixture(scope="session")
def installed(dist: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """The wheel in a new environment; its dependencies are links to those installed here."""
    folder = tmp_path_factory.mktemp("installed") / "venv"
    venv.create(folder, with_pip=False, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    link_dependencies(site)
    before = frozenset(path.name for path in site.iterdir())
    (wheel,) = dist.glob("*.whl")
    pip = (sys.executable, "-m", "pip", "--python", folder / "bin" / "python")
    run(*pip, "install", "--quiet", "--no-deps", "--no-index", wheel, cwd=folder)
    return Installed(folder, site, before)


def link_dependencies(site: Path) -> None:
    """Link the runtime dependencies of flexhex, and theirs, into an environment."""
    waiting, seen = ["flexhex"], set[str]()
    while waiting:
        distribution = metadata.distribution(waiting.pop())
        for text in distribution.requires or []:
            needed = Requirement(text)
            if needed.marker and not needed.marker.evaluate({"extra": ""}):
                continue
            if needed.name not in seen:
                seen.add(needed.name)
                waiting.append(needed.name)
        tops = {file.parts[0] for file in distribution.files or []} - {"..", "__pycache__"}
        for top in tops if distribution.name != "flexhex" else ():
            source = Path(str(distribution.locate_file(top)))
            if source.suffix != ".pth" and source.exists() and not (site / top).exists():
                (site / top).symlink_to(source)
