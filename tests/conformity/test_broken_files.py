"""Files that are broken, foreign or of another kind: one line that says so, never a traceback."""

from __future__ import annotations

import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from lxml import etree

from flexhex.check.fmu import check_fmu
from flexhex.check.ssp import check_system
from flexhex.fmus.common.errors import FlexhexError
from flexhex.ssp.fmu import read_fmu
from flexhex.ssp.read import read_ssp
from tests.conformity.archives import XML, members, write

NONSENSE = ("abc", "1e400", None)


def test_nonsense_in_any_attribute_is_a_complaint(toy: Path, tmp_path: Path) -> None:
    """Every attribute of every kind of element once; what is read for a run may refuse too."""
    files, tried, blamed = members(toy), set(), 0
    for k, element in enumerate(etree.fromstring(files[XML]).iter()):
        for attribute in element.attrib:
            if (element.tag, attribute) in tried:
                continue
            tried.add((element.tag, attribute))
            for value in NONSENSE:
                root = etree.fromstring(files[XML])
                other = list(root.iter())[k]
                if value is None:
                    del other.attrib[attribute]
                else:
                    other.set(attribute, value)
                data = {**files, XML: etree.tostring(root)}
                path = write(tmp_path / "toy.fmu", data)
                try:
                    blamed += bool(check_fmu(path, run=False))
                    read_fmu(path.read_bytes(), "toy.fmu")
                except FlexhexError:
                    blamed += 1
    assert len(tried) > 40
    assert blamed > len(tried), "most nonsense is noticed"


def said(folder: Path, *words: str) -> str:
    """What `flexhex` says in a folder; it must end with an error of one line."""
    command = [sys.executable, "-m", "flexhex", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    lines = [line for line in (done.stdout + done.stderr).splitlines() if "0:00" not in line]
    assert done.returncode in (1, 2, 3), done.stderr
    assert len(lines) == 1, lines
    return lines[0]


@pytest.mark.sample(5)
@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("check cut.fmu", "cut.fmu: not a zip archive, or a truncated one"),
        ("check folder.fmu", "folder.fmu: is a folder"),
        ("check nowhere.fmu", "nowhere.fmu: no such file"),
        ("check toy.txt", "toy.txt: nothing to check in '.txt', wants .fmu, .ssp, .toml"),
        ("check --results folder.fmu", "folder.fmu: is a folder"),
        ("check --results some.ssp", "is missing (a system description? an FMU is wanted)"),
        ("check without.ssp", "resources/plant.fmu is missing in the archive"),
        ("simulate without.ssp", "resources/plant.fmu is missing in the archive"),
        ("simulate toy.fmu", "toy.fmu: an FMU, not a system description (.ssp)"),
        ("export toy.fmu --container", "toy.fmu: an FMU, not a system description (.ssp)"),
        ("export some.ssp --variables -o toy.txt", "toy.txt: is a file, must be a folder"),
        ("export some.ssp --variables -o toy.txt/in", "part of this path is a file"),
        ("export some.ssp --for maestro -d inf", "--duration inf: must be a number of seconds"),
        ("export some.ssp --variables --platform win64", "--platform is for --container"),
        ("export some.ssp --for Simulink", "no wiring for 'Simulink', there is one for: cofmupy"),
    ],
)
def test_one_line_says_what_is_wrong(
    toy: Path, hexapod_ssp: Path, tmp_path: Path, words: str, says: str
) -> None:
    files = members(hexapod_ssp)
    (tmp_path / "some.ssp").write_bytes(hexapod_ssp.read_bytes())
    write(tmp_path / "without.ssp", {k: v for k, v in files.items() if "plant.fmu" not in k})
    (tmp_path / "toy.fmu").write_bytes(toy.read_bytes())
    (tmp_path / "cut.fmu").write_bytes(toy.read_bytes()[:2000])
    (tmp_path / "toy.txt").write_text("hello")
    (tmp_path / "folder.fmu").mkdir()
    assert says in said(tmp_path, *words.split())


def test_many_variables_take_no_longer_than_their_number(toy: Path, tmp_path: Path) -> None:
    """FMPy's grammar of names takes 5 ms for each of them, so it is not asked."""
    from lark import Lark

    files = members(toy)
    one = '<ScalarVariable name="m[{0}]" valueReference="{0}"><Real/></ScalarVariable>'
    more = "".join(one.format(k) for k in range(100, 20_100))
    files[XML] = files[XML].replace(b"</ModelVariables>", more.encode() + b"</ModelVariables>")
    path = write(tmp_path / "toy.fmu", files)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Lark, "parse", None)
        assert check_fmu(path, run=False) == []


def test_of_many_complaints_some_are_shown(toy: Path, tmp_path: Path) -> None:
    """And none of another kind is lost."""
    files = members(toy)
    one = '<ScalarVariable name="m {0}" valueReference="{0}"><Real/></ScalarVariable>'
    more = "".join(one.format(k) for k in range(100, 300))
    files[XML] = files[XML].replace(b"</ModelVariables>", more.encode() + b"</ModelVariables>")
    del files["documentation/index.html"]
    first, *names, rest = check_fmu(write(tmp_path / "toy.fmu", files), run=False)
    assert "index.html is missing" in first
    assert len(names) == 10
    assert rest.endswith("... and 190 more")


@pytest.mark.parametrize("kind", ["fmu", "ssp"])
def test_member_that_holds_more_than_the_archive_declares_is_damaged(
    kind: str, toy: Path, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """The directory declares 100 bytes of a megabyte; of a `.ssp` nothing else reads the member."""
    path = tmp_path / f"bomb.{kind}"
    files = {**members(toy if kind == "fmu" else hexapod_ssp), "resources/zero": bytes(2**20)}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    packed = bytearray(path.read_bytes())
    struct.pack_into("<I", packed, packed.rfind(b"PK\x01\x02") + 24, 100)
    path.write_bytes(packed)
    with pytest.raises(FlexhexError, match="resources/zero is damaged in the archive"):
        check_system(read_ssp(path)) if kind == "ssp" else check_fmu(path)
