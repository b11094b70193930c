"""Every mistake put into an FMU or a system description is found; what is well is not blamed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flexhex.check.fmu import check_fmu
from flexhex.check.ssp import check_ssp, check_system
from flexhex.fmus.common.errors import FlexhexError
from flexhex.ssp.read import read_ssp
from tests.conformity import mutants
from tests.conformity.archives import members, write
from tests.conformity.mutants_system import SYSTEM
from tests.conftest import ROOT


def complaints(path: Path) -> list[str]:
    """What the check says, errors that end it included."""
    try:
        return check_fmu(path) if path.suffix == ".fmu" else check_system(read_ssp(path))
    except FlexhexError as error:
        return [str(error)]


def test_unchanged_fmu_is_not_blamed(toy: Path) -> None:
    assert check_fmu(toy) == []


def test_packed_anew_it_is_not_blamed(toy: Path, tmp_path: Path) -> None:
    """So what the mutants are blamed for is their mistake, not the packing."""
    assert check_fmu(write(tmp_path / "toy.fmu", members(toy))) == []


@pytest.mark.sample(15)
@pytest.mark.parametrize("kind", mutants.FMU)
def test_mistake_in_an_fmu_is_found(toy: Path, tmp_path: Path, kind: str) -> None:
    change, wanted = mutants.FMU[kind]
    files = members(toy)
    change(files)
    messages = complaints(write(tmp_path / "toy.fmu", files))
    print(f"{kind:40} {messages[0].partition(': ')[2] if messages else '-'}")
    assert any(re.search(wanted, text) for text in messages), messages


@pytest.mark.sample(5)
@pytest.mark.parametrize("kind", SYSTEM)
def test_mistake_in_a_system_is_found(hexapod_ssp: Path, tmp_path: Path, kind: str) -> None:
    change, wanted = SYSTEM[kind]
    files = members(hexapod_ssp)
    change(files)
    messages = complaints(write(tmp_path / "hexapod.ssp", files))
    print(f"{kind:40} {messages[0].partition(': ')[2] if messages else '-'}")
    assert any(re.search(wanted, text) for text in messages), messages


def test_our_fmus_and_systems_are_not_blamed(fmu_dir: Path, machine_ssp: Path) -> None:
    """The system's own FMUs are checked with it: all but machine.fmu's sibling plant.fmu."""
    assert check_ssp(machine_ssp) == []
    assert check_fmu(fmu_dir / "plant.fmu") == []


def test_kinds_are_as_many_as_the_readme_says() -> None:
    said = re.search(r"(\d+) kinds of mistakes", (ROOT / "build" / "README.md").read_text())
    assert said is not None
    assert len(mutants.FMU) + len(SYSTEM) == int(said[1])
