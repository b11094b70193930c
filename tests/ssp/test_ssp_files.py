"""The .ssp file: valid, reproducible, read back as written."""

from __future__ import annotations

import re
from pathlib import Path

import fmpy
import pytest
from fmpy.ssp.ssd import read_ssd, read_ssv
from lxml import etree

from flexhex.fmugen.fmu import build_fmu
from flexhex.ssp.hexapod import hexapod
from flexhex.ssp.read import period, read_ssp
from flexhex.ssp.system import System
from flexhex.ssp.write import write_ssp
from flexhex.ssp.xml import NAMESPACES
from tests.conftest import OBJECTS
from tests.ssp import toys
from tests.ssp.archives import edited, members
from tests.ssp.test_system import blocks

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"


@pytest.fixture(scope="session")
def toy_hexapod(work: Path) -> tuple[System, Path]:
    """The full wiring of the hexapod with FMUs that do nothing."""
    small = hexapod(blocks((3, 4, 5)))
    folder = work / "hexapod"
    for interface in {c.interface.name: c.interface for c in small.components}.values():
        step = folder / "blocks" / interface.name / "step.c"
        step.parent.mkdir(parents=True, exist_ok=True)
        step.write_text(toys.NOTHING_C.replace("NAME", interface.name))
        build_fmu(interface, [], step, folder, cache=OBJECTS)
    return small, write_ssp(small, folder, folder / "hexapod.ssp")


def test_hexapod_is_valid_against_the_standard(toy_hexapod: tuple[System, Path]) -> None:
    _, path = toy_hexapod
    for name, data in members(path).items():
        kind = {"ssd": "Description", "ssv": "ParameterValues"}.get(name.rpartition(".")[2])
        if kind:
            schema = etree.XMLSchema(file=str(SCHEMAS / f"SystemStructure{kind}.xsd"))
            schema.assertValid(etree.fromstring(data))
    read_ssd(str(path))  # FMPy validates once more and finds every connection's ends


def test_invalid_document_is_seen_by_the_schema(ring_ssp: Path, tmp_path: Path) -> None:
    broken = edited(ring_ssp, tmp_path / "x.ssp", 'kind="input"', 'kind="inlet"')
    with pytest.raises(Exception, match="Failed to validate"):
        read_ssd(str(broken))


def test_libcosims_annotation_declares_the_base_step(ring_ssp: Path) -> None:
    document = etree.fromstring(members(ring_ssp)["SystemStructure.ssd"])
    osp = document.find("ssd:DefaultExperiment//osp:FixedStepAlgorithm", NAMESPACES)
    assert float(osp.get("baseStepSize")) == 0.00025
    assert b"StepSizeHint" not in members(ring_ssp)["SystemStructure.ssd"]


def test_omsimulators_importfile_finds_the_base_step(ring_ssp: Path) -> None:
    """As its C++ reads: names with the prefix as it stands, of annotations only the first one,
    and the kind of master from the child that has a description (Model.cpp, SystemWC.cpp)."""
    text = members(ring_ssp)["SystemStructure.ssd"].decode()
    system = text[text.index("</ssd:Connections>") : text.index("</ssd:System>")]
    first = system[system.index("<ssc:Annotation ") : system.index("</ssc:Annotation>")]
    words = re.findall(r'<([\w:]+)|(\w+)="([^"]*)"', first)
    assert [tag for tag, _, _ in words if tag] == [
        "ssc:Annotation",
        "oms:Annotations",
        "oms:SimulationInformation",
        "oms:FixedStepMaster",
    ]
    values = {key: value for _, key, value in words if key}
    assert values["type"] == "org.openmodelica"
    assert values["description"] == "oms-ma"
    assert float(values["stepSize"]) == 0.00025


def test_omsimulators_python_classes_find_the_base_step(ring_ssp: Path) -> None:
    """As `SSP` and `System.processElements` read: components that name no solver have the system's
    of this name; without one they would step by 1 ms."""
    document = etree.fromstring(members(ring_ssp)["SystemStructure.ssd"])
    path = "ssd:Annotations/ssc:Annotation[@type='org.openmodelica']/oms:Annotations/*"
    (solver,) = document.find("ssd:System", NAMESPACES).iterfind(path, NAMESPACES)
    assert solver.get("name") == "oms_ma_default"
    assert (solver.get("method"), float(solver.get("fixedStepSize"))) == ("oms_ma", 0.00025)
    # of the experiment it takes its logging from such an annotation, and no step
    assert document.find("ssd:DefaultExperiment//oms:SimulationInformation", NAMESPACES) is None


def test_omsimulators_importfile_knows_every_element(hexapod_ssp: Path) -> None:
    """It refuses a system or component with any other: no annotations of components, in no version,
    and no SystemGeometry since version 3 (ComponentFMUCS.cpp, System.cpp)."""
    known = {
        "System": {"ParameterBindings", "Elements", "Connections", "Annotations"},
        "Component": {"Connectors", "ElementGeometry", "ParameterBindings"},
    }
    document = etree.fromstring(members(hexapod_ssp)["SystemStructure.ssd"])
    for kind, allowed in known.items():
        elements = document.iterfind(f".//ssd:{kind}", NAMESPACES)
        tags = {etree.QName(child).localname for element in elements for child in element}
        assert tags - allowed == set()


def test_schedule_carries_periods_and_delays(toy_hexapod: tuple[System, Path]) -> None:
    document = etree.fromstring(members(toy_hexapod[1])["SystemStructure.ssd"])
    periods = {
        e.get("component"): int(e.get("steps"))
        for e in document.iterfind(".//flexhex:Period", NAMESPACES)
    }
    assert (periods["plant"], periods["N_E"], periods["K"]) == (1, 2, 120)
    torque = document.find(".//flexhex:Delay", NAMESPACES)
    assert torque.get("path") == "reference N_F F feedback plant"
    assert (torque.get("shortest"), torque.get("longest")) == ("5", "6")


def test_only_connectors_in_use_and_plots_are_listed(toy_hexapod: tuple[System, Path]) -> None:
    system, path = toy_hexapod
    listed = {
        (c.name, k.name, k.kind) for c in read_ssd(str(path)).system.elements for k in c.connectors
    }
    inputs = {(w.target, w.input) for w in system.wires}
    assert {(c, k) for c, k, kind in listed if kind == "input"} == inputs
    outputs = {(c, k) for c, k, kind in listed if kind == "output"}
    assert ("K", "innovation[1]") in outputs
    assert ("K", "p_std.actuator[1].o") not in outputs


def test_diagram_is_drawn_like_figure_3(toy_hexapod: tuple[System, Path]) -> None:
    document = etree.fromstring(members(toy_hexapod[1])["SystemStructure.ssd"])
    centre = {}
    for component in document.iterfind(".//ssd:Component", NAMESPACES):
        box = component.find("ssd:ElementGeometry", NAMESPACES)
        x1, y1, x2, y2 = (float(box.get(key)) for key in ("x1", "y1", "x2", "y2"))
        centre[component.get("name")] = (x1 + x2) / 2, (y1 + y2) / 2
    x = {name: c[0] for name, c in centre.items()}
    y = {name: c[1] for name, c in centre.items()}
    assert x["reference"] < x["feedback"] < x["plant"]
    assert x["N_F"] < x["F"]
    assert y["reference"] == y["feedback"] == y["plant"]
    assert y["N_F"] == y["F"] > y["feedback"] > y["W"] == y["N_E"] == y["K"]
    assert x["K"] < x["N_E"] < x["W"]


def test_parameter_sets_share_one_name_and_repeat_the_fmus_values(ring_ssp: Path) -> None:
    for source in ("src", "a", "a2", "b", "c"):
        values = read_ssv(str(ring_ssp), resource=f"resources/{source}.ssv")
        assert values.name == "parameters"
        read = {p.name: float(p.value) for p in values.parameters}
        wanted = {"gain": toys.GAIN} if source == "src" else {"keep": toys.KEEP}
        assert {k: v for k, v in read.items() if k != "Ts"} == wanted


def test_archive_is_reproducible(work: Path, tmp_path: Path, ring_ssp: Path) -> None:
    again = write_ssp(toys.ring(), work, tmp_path / "again.ssp")
    assert again.read_bytes() == ring_ssp.read_bytes()


def test_reader_gives_back_what_was_written(ring_ssp: Path) -> None:
    system, package = toys.ring(), read_ssp(ring_ssp)
    assert package.wires == system.wires
    assert package.base == system.base
    assert [i.name for i in package.instances] == [c.name for c in system.components]
    assert [period(i, package.base) for i in package.instances] == [1, 1, 1, 2, 120]
    assert package.instance("src").parameters == {"Ts": 0.00025, "gain": toys.GAIN}


def test_system_level_parameters_win(ring_ssp: Path, tmp_path: Path) -> None:
    # SSP 1.0: bindings at system level take precedence; unknown names are ignored
    inline = (
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet"
        ' version="1.0" name="s"><ssv:Parameters><ssv:Parameter name="b.keep"><ssv:Real'
        ' value="0.1"/></ssv:Parameter><ssv:Parameter name="b.nothing"><ssv:Real value="1"/>'
        "</ssv:Parameter></ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues>"
        "</ssd:ParameterBinding></ssd:ParameterBindings><ssd:Elements>"
    )
    path = edited(ring_ssp, tmp_path / "x.ssp", "<ssd:Elements>", inline)
    instance = read_ssp(path).instance("b")
    assert instance.parameters["keep"] == 0.1
    assert instance.ignored == ("nothing",)


def test_base_step_is_found_in_foreign_files(ring_ssp: Path, tmp_path: Path) -> None:
    path = edited(ring_ssp, tmp_path / "x.ssp", "flexhex:Schedule", "flexhex:Other")
    path = edited(path, tmp_path / "y.ssp", 'baseStepSize="0.00025"', 'baseStepSize="0.000125"')
    assert read_ssp(path).base == 0.000125
    path = edited(path, tmp_path / "z.ssp", "FixedStepAlgorithm", "Other")
    assert read_ssp(path).base == 0.00025
