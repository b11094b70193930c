"""What the generator makes: a valid, reproducible archive, and one-line errors when it cannot."""

from __future__ import annotations

import dataclasses
import math
import re
import zipfile
from pathlib import Path

import casadi as ca
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from flexhex.fmugen import compile as compiling
from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.common.errors import BuildError, InterfaceError
from flexhex.fmus.common.interface import Interface, Variable
from tests.adapter import toys
from tests.adapter.slave import ERROR, Binary, Slave
from tests.adapter.toys import VR
from tests.conftest import OBJECTS


def changed(interface: Interface, name: str, **changes: object) -> Interface:
    """The interface with one variable changed."""
    variables = tuple(
        dataclasses.replace(v, **changes) if v.name == name else v  # type: ignore[arg-type]
        for v in interface.variables
    )
    return dataclasses.replace(interface, variables=variables)


def without_compiler(monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    monkeypatch.setenv("CC", command)
    monkeypatch.setattr(compiling, "compiler", compiling.compiler.__wrapped__)
    monkeypatch.setattr(compiling, "version", lambda: "test")


def test_fmpy_finds_nothing_wrong(toy_fmu: Path) -> None:
    assert validate_fmu(str(toy_fmu)) == []


def test_validator_would_notice(toy_fmu: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(toy_fmu) as old, zipfile.ZipFile(broken, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            new.writestr(name, data.replace(b'unit="rad"', b'unit="deg"'))
    assert validate_fmu(str(broken)) != []


def test_archive_is_the_same_from_two_folders(toy_fmu: Path, tmp_path: Path) -> None:
    again = toys.build(tmp_path / "some" / "where")
    assert again.read_bytes() == toy_fmu.read_bytes()
    other = toys.build(tmp_path / "other", OBJECTS, offset=0.25)
    assert other.read_bytes() != toy_fmu.read_bytes()


def test_archive_holds_what_it_lists_and_no_paths(toy: Binary, toy_fmu: Path) -> None:
    with zipfile.ZipFile(toy_fmu) as archive:
        names = archive.namelist()
        contents = [archive.read(name) for name in names]
    listed = {f"sources/{f.get('name')}" for f in toy.xml.iterfind("CoSimulation/SourceFiles/File")}
    assert listed == {name for name in names if name.endswith(".c")}
    assert {"documentation/index.html", "binaries/linux64/toy.so"} <= set(names)
    for part in (str(Path.home()), str(toy_fmu.parent), str(Path(__file__).parent)):
        assert not any(part.encode() in data for data in contents), part


def test_capabilities_are_those_of_the_binary(toy: Binary) -> None:
    """Each claim is exercised by a test of this folder."""
    cosimulation = toy.xml.find("CoSimulation")
    claims = {k: v for k, v in cosimulation.attrib.items() if v in ("true", "false")}
    assert {k for k, v in claims.items() if v == "true"} == {
        "canHandleVariableCommunicationStepSize",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
    }
    assert toy.xml.find("DefaultExperiment").get("stepSize") == "0.00025"
    assert toy.xml.get("generationDateAndTime") is None


def test_outputs_depend_on_no_input(toy: Binary) -> None:
    unknowns = toy.xml.findall("ModelStructure/Outputs/Unknown")
    assert [u.get("dependencies") for u in unknowns] == [""] * len(toys.OUTPUTS)


def test_other_start_values_compile_one_table(tmp_path: Path) -> None:
    toys.build(tmp_path)
    before = set((tmp_path / "cache").glob("*.o"))
    toys.build(tmp_path, offset=0.123)
    new = set((tmp_path / "cache").glob("*.o")) - before
    assert [p.name.split("-")[0] for p in new] == ["toy_fmu"]


def test_adapter_is_compiled_once_for_fmus_of_any_name(tmp_path: Path) -> None:
    toys.build(tmp_path)
    before = set((tmp_path / "cache").glob("*.o"))
    toys.build(tmp_path, name="toy_other")
    new = set((tmp_path / "cache").glob("*.o")) - before
    assert sorted(p.name.split("-")[0] for p in new) == [
        "toy_other_casadi",
        "toy_other_fmu",
        "toy_other_step",
    ]


def test_numbers_read_back_exactly(tmp_path: Path) -> None:
    odd = (0.1 + 0.2, 5e-324, -1.7976931348623157e308)
    interface = changed(toys.interface(), "begin", start=odd)
    path = build_fmu(interface, toys.functions(), toys.STEP_C, tmp_path, cache=OBJECTS)
    binary = Binary(path, tmp_path / "unpacked")
    slave = Slave(binary)
    slave.call("fmi2EnterInitializationMode")
    names = [f"begin[{k}]" for k in (1, 2, 3)]
    assert tuple(slave.get([VR[name] for name in names])) == odd
    elements = [binary.xml.find(f".//ScalarVariable[@name='{name}']/Real") for name in names]
    assert tuple(float(element.get("start")) for element in elements) == odd
    slave.free()


def test_elements_carry_their_own_units_and_names(tmp_path: Path) -> None:
    interface = changed(
        toys.interface(),
        "begin",
        units=("rad", "N m", "kg m2"),
        elements=("tilt", "[2]", "body.J[1]"),
    )
    path = build_fmu(interface, toys.functions(), toys.STEP_C, tmp_path, cache=OBJECTS)
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        xml = etree.fromstring(archive.read("modelDescription.xml"))
    names = ("begin.tilt", "begin[2]", "begin.body.J[1]")
    elements = [xml.find(f".//ScalarVariable[@name='{name}']") for name in names]
    assert [v.find("Real").get("unit") for v in elements] == ["rad", "N m", "kg m2"]
    slave = Slave(Binary(path, tmp_path / "unpacked"))
    for name in names:
        assert slave.set([VR["begin[1]"] + names.index(name)], [math.nan]) == ERROR
        assert f"{name} = nan" in slave.said, "the binary knows the name too"
    inertia = xml.find("UnitDefinitions/Unit[@name='kg m2']/BaseUnit")
    assert dict(inertia.attrib) == {"kg": "1", "m": "2"}


def test_equations_need_no_work_memory(toy: Binary) -> None:
    """step.c calls them with null work vectors."""
    text = (toy.folder / "sources" / "toy_casadi.c").read_text()
    assert "(void)iw, (void)w" in text
    assert not re.search(r"\bi?w *\[", text)


def test_functions_that_are_not_sx_are_refused(tmp_path: Path) -> None:
    x = ca.MX.sym("x")
    function = ca.Function("toy_scale", [x], [x])
    with pytest.raises(BuildError, match="toy_scale: MXFunction, must be made of SX"):
        build_fmu(toys.interface(), [function], toys.STEP_C, tmp_path)


def test_functions_that_call_others_are_refused(tmp_path: Path) -> None:
    """CasADi keeps a callee's values in work vectors, and step.c gives none."""
    x = ca.SX.sym("x")
    inner = ca.Function("inner", [x], [ca.sin(x)], {"never_inline": True})
    function = ca.Function("toy_scale", [x], [2 * inner(x)])
    with pytest.raises(BuildError, match="toy_scale: calls another function, must be expanded"):
        build_fmu(toys.interface(), [function], toys.STEP_C, tmp_path)


def test_function_of_another_block_is_refused(tmp_path: Path) -> None:
    x = ca.SX.sym("x")
    function = ca.Function("other_scale", [x], [x])
    with pytest.raises(BuildError, match="must be called toy_<what>"):
        build_fmu(toys.interface(), [function], toys.STEP_C, tmp_path)


def test_unknown_unit_is_refused_with_the_variable(tmp_path: Path) -> None:
    interface = changed(toys.interface(), "y", unit="furlong")
    with pytest.raises(InterfaceError, match="y: unknown unit 'furlong'"):
        build_fmu(interface, toys.functions(), toys.STEP_C, tmp_path)


def test_missing_compiler_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without_compiler(monkeypatch, "no-such-compiler -x")
    with pytest.raises(BuildError, match=r"no C compiler: \$CC = 'no-such-compiler -x'"):
        toys.build(tmp_path)


def test_failing_compiler_is_quoted(tmp_path: Path) -> None:
    folder = tmp_path / "toy"
    folder.mkdir()
    step = folder / "step.c"
    step.write_text('#include "toy.h"\nint broken(void) { return undeclared; }\n')
    with pytest.raises(BuildError, match="undeclared") as error:
        build_fmu(toys.interface(), toys.functions(), step, tmp_path / "out", cache=OBJECTS)
    assert len(str(error.value).splitlines()) <= 13
    assert not list((tmp_path / "out").glob("*.fmu"))


def test_block_that_does_not_fit_its_table_is_refused(tmp_path: Path) -> None:
    """A step.c compiled against other variables than the table lists."""
    folder = tmp_path / "toy"
    folder.mkdir()
    text = toys.STEP_C.read_text().replace("FLEXHEX_BLOCK(toy,", "FLEXHEX_BLOCK(wrong,")
    text = text.replace(
        "FLEXHEX_BLOCK(wrong,",
        "typedef toy_parameters wrong_parameters;\ntypedef toy_outputs wrong_outputs;\n"
        "typedef struct { double u[9]; } wrong_inputs;\n#define wrong_block toy_block\n"
        "static void bad(const wrong_parameters *p, const wrong_inputs *u, void *s,"
        " wrong_outputs *y) { (void)u, tick(p, NULL, s, y); }\nFLEXHEX_BLOCK(wrong,",
    ).replace("start, tick)", "start, bad)")
    (folder / "step.c").write_text(text)
    made = (toys.interface(), toys.functions(), folder / "step.c", tmp_path / "out")
    path = build_fmu(*made, cache=OBJECTS)
    slave = Slave(Binary(path, tmp_path / "unpacked"))
    assert not slave.c
    assert "the table of variables does not fit step.c" in slave.said


def test_blocks_without_inputs_or_equations_build(tmp_path: Path) -> None:
    folder = tmp_path / "still"
    folder.mkdir()
    (folder / "step.c").write_text(
        '#include "still.h"\n\ntypedef struct { double none; } state;\n'
        "static bool start(const still_parameters *p, void *s, still_outputs *y, char *m,"
        " size_t n) {\n  (void)p, (void)s, (void)m, (void)n;\n  y->one = 1.0;\n  return true;\n}\n"
        "static void tick(const still_parameters *p, const still_inputs *u, void *s,"
        " still_outputs *y) {\n  (void)p, (void)u, (void)s;\n  y->one += 1.0;\n}\n"
        "FLEXHEX_BLOCK(still, state, start, tick)\n"
    )
    one = (Variable("one", "output", "1", "counts"),)
    interface = Interface("still", "no input, no equation", toys.BASE, one)
    path = build_fmu(interface, [], folder / "step.c", tmp_path / "out", cache=OBJECTS)
    assert validate_fmu(str(path)) == []
    slave = Slave(Binary(path, tmp_path / "unpacked")).initialise()
    slave.advance(5)
    assert slave.get([1, 2]) == [5.0, 0.0]
    slave.free()
