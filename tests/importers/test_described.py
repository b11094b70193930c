"""An FMU's modelDescription.xml says all that its interface did."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from lxml import etree

from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmugen.described import interface_of
from flexhex.fmugen.description import model_description
from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.system import BASE_STEP


def description_of(path: Path) -> bytes:
    """modelDescription.xml of an FMU."""
    with zipfile.ZipFile(path) as archive:
        return archive.read("modelDescription.xml")


@pytest.mark.parametrize("block", [*BLOCKS, "machine"])
def test_interface_read_back_writes_the_same_description(fmu_dir: Path, block: str) -> None:
    text = description_of(fmu_dir / f"{block}.fmu")
    root = etree.fromstring(text)
    sources = [str(f.get("name")) for f in root.iterfind(".//SourceFiles/File")]
    again = model_description(interface_of(text, block), BASE_STEP, str(root.get("guid")), sources)
    assert again == text


def test_foreign_and_broken_descriptions_are_refused() -> None:
    with pytest.raises(InterfaceError, match=r"other.fmu: written by 'Other', not by flexhex"):
        interface_of(b"<fmiModelDescription generationTool='Other'/>", "other.fmu")
    with pytest.raises(InterfaceError, match=r"other.fmu: not valid XML"):
        interface_of(b"<fmiModelDescription>", "other.fmu")
