"""Broken .ssp files and FMUs that do not fit are refused by name."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.read import read_ssp
from flexhex.ssp.write import write_ssp
from tests.ssp import toys
from tests.ssp.archives import changed, edited, heavy

SSD = "SystemStructure.ssd"
BROKEN: list[tuple[str, str, str, str]] = [
    ("XML", "</ssd:System>", "", "not valid XML"),
    ("namespace", "SSP1/SystemStructureDescription", "SSP9/Other", "is no SSP 1.x system"),
    ("wire", 'startElement="src"', 'startElement="scr"', "no component 'scr', did you mean 'src'"),
    ("connector", 'endConnector="v"', 'endConnector="w"', "no variable 'w'"),
    ("source", "resources/relay2.fmu", "resources/relay3.fmu", "relay3.fmu is missing"),
    ("ssv", "resources/b.ssv", "resources/q.ssv", "q.ssv is missing"),
    ("type", "x-fmu-sharedlibrary", "x-ssp-package", "'application/x-ssp-package' is no FMU"),
    ("step", 'baseStep="0.00025"', 'baseStep="-1"', "must be a positive number"),
    ("twice", 'name="a2"', 'name="a"', "component 'a' exists twice"),
    ("outside", 'startElement="src" ', "", "connector of the system"),
]


@pytest.mark.parametrize(("what", "old", "new", "text"), BROKEN, ids=[b[0] for b in BROKEN])
def test_broken_description_is_refused(
    ring_ssp: Path, tmp_path: Path, what: str, old: str, new: str, text: str
) -> None:
    path = edited(ring_ssp, tmp_path / "broken.ssp", old, new)
    with pytest.raises(InterfaceError, match=rf"broken.ssp: .*{text}"):
        read_ssp(path)


def test_fmus_that_unpack_to_too_much_together_are_refused(ring_ssp: Path, tmp_path: Path) -> None:
    """Each alone is within the limit; nothing is unpacked, as they hold less than they declare."""

    def change(files: dict[str, bytes]) -> None:
        for name in [name for name in files if name.endswith(".fmu")]:
            files[name] = heavy(files[name], 600 * 2**20)

    path = changed(ring_ssp, tmp_path / "heavy.ssp", change)
    with pytest.raises(
        InterfaceError, match=r"with its FMU the system unpacks to 120\d MB, at most"
    ):
        read_ssp(path)


def test_transformation_is_refused(ring_ssp: Path, tmp_path: Path) -> None:
    old = 'endElement="a" endConnector="v"/>'
    new = old[:-2] + '><ssc:LinearTransformation factor="2"/></ssd:Connection>'
    path = edited(ring_ssp, tmp_path / "x.ssp", old, new)
    with pytest.raises(InterfaceError, match="holds transformations: the executor runs flat"):
        read_ssp(path)


def test_missing_truncated_and_foreign_files_are_refused(ring_ssp: Path, tmp_path: Path) -> None:
    with pytest.raises(InterfaceError, match=r"nothing.ssp: no such file"):
        read_ssp(tmp_path / "nothing.ssp")
    cut = tmp_path / "cut.ssp"
    cut.write_bytes(ring_ssp.read_bytes()[:-100])
    with pytest.raises(InterfaceError, match="not a zip archive, or a truncated one"):
        read_ssp(cut)
    empty = changed(ring_ssp, tmp_path / "empty.ssp", lambda files: files.pop(SSD))
    with pytest.raises(InterfaceError, match=r"SystemStructure.ssd is missing"):
        read_ssp(empty)
    damaged = tmp_path / "damaged.ssp"
    raw = bytearray(ring_ssp.read_bytes())
    at = raw.find(b"resources/relay1.fmu") + 200
    raw[at : at + 50] = bytes(50)
    damaged.write_bytes(bytes(raw))
    with pytest.raises(InterfaceError, match=r"relay1.fmu is damaged"):
        read_ssp(damaged)


def test_fmu_that_is_none_is_refused(ring_ssp: Path, tmp_path: Path) -> None:
    name = "resources/relay2.fmu"
    path = changed(ring_ssp, tmp_path / "x.ssp", lambda files: files.update({name: b"no zip"}))
    with pytest.raises(InterfaceError, match=r"relay2.fmu: not a zip archive"):
        read_ssp(path)


def test_fmu_with_another_unit_is_not_packed(work: Path, tmp_path: Path) -> None:
    system = toys.ring()
    b = system.component("b")
    heavy = dataclasses.replace(b.interface.variables[0], unit="kg")
    changed_block = dataclasses.replace(b.interface, variables=(heavy, *b.interface.variables[1:]))
    components = tuple(
        dataclasses.replace(c, interface=changed_block) if c.name == "b" else c
        for c in system.components
    )
    wrong = dataclasses.replace(system, components=components)
    with pytest.raises(InterfaceError, match=r"b.keep: relay2.fmu has parameter \[1\], its"):
        write_ssp(wrong, work, tmp_path / "x.ssp")


def test_fmu_of_another_interface_is_not_packed(work: Path, tmp_path: Path) -> None:
    for file in work.glob("*.fmu"):
        shutil.copy(file, tmp_path / file.name)
    shutil.copy(tmp_path / "source1.fmu", tmp_path / "relay2.fmu")
    with pytest.raises(InterfaceError, match=r"b: in relay2.fmu there is no variable 'keep'"):
        write_ssp(toys.ring(), tmp_path, tmp_path / "x.ssp")
    (tmp_path / "relay2.fmu").unlink()
    with pytest.raises(InterfaceError, match=r"relay2.fmu: no such file"):
        write_ssp(toys.ring(), tmp_path, tmp_path / "x.ssp")
