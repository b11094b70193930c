"""`flexhex export`: the table of variables, the diagram, the command itself."""

from __future__ import annotations

import csv
import itertools
import zipfile
from pathlib import Path

import fmpy
import pytest
from lxml import etree
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.export.diagram import export_diagram
from flexhex.export.variables import COLUMNS, export_variables
from flexhex.fmus.common.errors import InterfaceError, UsageError
from flexhex.ssp.diagram import Shape, read_diagram, symbol
from tests.conftest import ROOT
from tests.ssp import toys


def test_table_holds_every_variable_as_fmpy_reads_it(hexapod_ssp: Path, tmp_path: Path) -> None:
    with export_variables([hexapod_ssp], tmp_path / "v.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    with zipfile.ZipFile(hexapod_ssp) as archive:
        archive.extractall(tmp_path)
    fmus = sorted((tmp_path / "resources").glob("*.fmu"))
    assert {row["fmu"] for row in rows} == {path.name for path in fmus}
    for path in fmus:
        ours = [row for row in rows if row["fmu"] == path.name]
        theirs = fmpy.read_model_description(str(path)).modelVariables
        assert [(r["name"], int(r["valueReference"]), r["causality"]) for r in ours] == [
            (v.name, v.valueReference, v.causality) for v in theirs
        ]
        assert [(r["unit"], r["start"], r["min"]) for r in ours] == [
            (v.unit or "", v.start or "", v.min or "") for v in theirs
        ]
    angle = next(r for r in rows if r["fmu"] == "plant.fmu" and r["name"] == "theta[1]")
    assert (angle["unit"], angle["type"]) == ("rad", "Real")
    assert angle["display unit"] in {"deg", "urad"}
    fault = next(r for r in rows if r["fmu"] == "plant.fmu" and r["name"] == "fault")
    assert fault["description"] == "what is wrong: 0 none, 1 refused, 2 end_stop, 3 diverged"


def test_table_of_another_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"x.toml: wants .fmu or .ssp"):
        export_variables([Path("x.toml")], tmp_path / "v.csv")


def crosses(start: tuple[float, float], end: tuple[float, float], shape: Shape) -> bool:
    """Whether a level or upright stretch runs through the inside of a box."""
    (x1, x2), (y1, y2) = sorted((start[0], end[0])), sorted((start[1], end[1]))
    return x1 < shape.right and x2 > shape.left and y1 < shape.top and y2 > shape.bottom


def test_lines_of_the_diagram_go_around_the_boxes(hexapod_ssp: Path) -> None:
    diagram = read_diagram(hexapod_ssp)
    assert len(diagram.shapes) == 8
    assert len(diagram.lines) == 12
    for line in diagram.lines:
        for start, end in itertools.pairwise(line.points):
            assert start[0] == end[0] or start[1] == end[1], f"{line}: a slanted stretch"
            for shape in diagram.shapes:
                assert not crosses(start, end, shape), f"{line.names} runs through {shape.name}"
    middle = diagram.shapes[3]
    assert crosses((0.0, middle.bottom + 5), (700.0, middle.bottom + 5), middle)


def test_committed_diagram_is_the_one_of_the_ssp(hexapod_ssp: Path, tmp_path: Path) -> None:
    drawn = export_diagram(hexapod_ssp, tmp_path / "loop.svg").read_text()
    etree.fromstring(drawn.encode())
    again = "flexhex export out/hexapod.ssp --diagram, then copy it to docs/loop.svg"
    assert (ROOT / "docs" / "loop.svg").read_text() == drawn, again


def test_system_without_coordinates_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InterfaceError, match=r"chain.ssp: c0 has no ssd:ElementGeometry"):
        read_diagram(toys.pack(toys.chain(1), tmp_path))


@pytest.mark.parametrize(
    ("name", "shown"),
    [("theta_fd", "θ\u0307_f"), ("rdd", "r\u0308"), ("tau_ff", "τ_FF"), ("payload", "payload")],
)
def test_symbols_are_the_papers(name: str, shown: str) -> None:
    assert symbol(name) == shown


def test_command_writes_what_is_asked_for(hexapod_ssp: Path, tmp_path: Path) -> None:
    call = ["export", str(hexapod_ssp), "--variables", "--diagram", "--for", "osp"]
    done = CliRunner().invoke(app, [*call, "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    names = ["osp/OspSystemStructure.xml", "variables.csv", "hexapod.svg"]
    assert done.output.split() == [str(tmp_path / name) for name in names]
    assert all((tmp_path / name).stat().st_size for name in names)


def test_command_writes_into_the_current_folder_by_default(
    hexapod_ssp: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As all commands do: the .ssp may lie where nobody but its owner writes."""
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["export", str(hexapod_ssp), "--variables"])
    assert done.output.split() == ["out/export/variables.csv"]
    assert (tmp_path / "out/export/variables.csv").stat().st_size


def test_command_without_a_wish_says_what_there_is(hexapod_ssp: Path) -> None:
    done = CliRunner().invoke(app, ["export", str(hexapod_ssp)])
    assert isinstance(done.exception, UsageError)
    assert "--container" in str(done.exception)
