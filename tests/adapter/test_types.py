"""Booleans, Integers, enumerations, bounds of elements: as described, read, set, and refused with
what words."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Iterator

import pytest
from fmpy.validation import validate_fmu

from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface, Item
from tests.adapter import toys
from tests.adapter.slave import ERROR, OK, Binary, Slave
from tests.adapter.test_archive import changed
from tests.adapter.toys import VR
from tests.conftest import OBJECTS

MODES = (Item("off", "no output"), Item("single", "u"), Item("double", "2 u"))


def interface() -> Interface:
    """The toy with a parameter of each type; its equations see numbers."""
    variant = changed(toys.interface("typed"), "offset", type="Boolean", unit="1", start=1.0)
    variant = changed(variant, "gain", type="Enumeration", start=2.0, items=MODES)
    return changed(variant, "begin", type="Integer", unit="1", start=(1, 2, 3), min=-5, max=5)


@pytest.fixture(scope="module")
def binary(tmp_path_factory: pytest.TempPathFactory) -> Binary:
    folder = tmp_path_factory.mktemp("typed")
    path = build_fmu(interface(), toys.functions(), toys.STEP_C, folder, cache=OBJECTS)
    assert validate_fmu(str(path)) == []
    return Binary(path, folder / "unpacked")


@pytest.fixture
def typed(binary: Binary) -> Iterator[Slave]:
    slave = Slave(binary)
    assert slave.setup() == OK
    assert slave.call("fmi2EnterInitializationMode") == OK
    yield slave
    slave.free()


def call(slave: Slave, function: str, name: str, value: float) -> int:
    """A setter whatever the variable's type is."""
    number = ct.c_double(value) if function.endswith("Real") else ct.c_int(int(value))
    return slave.call(function, (ct.c_uint * 1)(VR[name]), ct.c_size_t(1), ct.byref(number))


def test_description_names_types_and_items(binary: Binary) -> None:
    elements = {v.get("name"): v[0] for v in binary.xml.iter("ScalarVariable")}
    assert dict(elements["offset"].attrib) == {"start": "true"}
    assert dict(elements["begin[2]"].attrib) == {"start": "2", "min": "-5", "max": "5"}
    assert dict(elements["gain"].attrib) == {"declaredType": "typed_gain", "start": "2"}
    items = binary.xml.iterfind("TypeDefinitions/SimpleType[@name='typed_gain']/Enumeration/Item")
    listed = [(i.get("name"), i.get("value"), i.get("description")) for i in items]
    assert listed == [(item.name, str(k), item.description) for k, item in enumerate(MODES)]
    assert all(elements[name].tag == "Real" for name in ("u", "y", "integral[1]"))


def test_values_of_all_types_take_part_in_the_step(typed: Slave) -> None:
    references = [VR["offset"], VR["gain"], VR["begin[1]"]]
    assert typed.get(references) == [1.0, 2.0, 1.0]
    assert typed.set(references, [0.0, 1.0, -4.0]) == OK
    assert typed.get(references) == [0.0, 1.0, -4.0]
    assert typed.call("fmi2ExitInitializationMode") == OK
    assert typed.set([VR["u"]], [0.25]) == OK
    typed.advance(4)
    assert typed.get([VR["y"], VR["integral[1]"]]) == [0.25, -4.0]


@pytest.mark.parametrize(
    ("function", "name", "value", "text"),
    [
        ("fmi2SetBoolean", "offset", 2, "offset = 2, allowed 0 to 1"),
        ("fmi2SetBoolean", "offset", -1, "offset = -1, allowed 0 to 1"),
        ("fmi2SetInteger", "gain", 3, "gain = 3, allowed 0 to 2"),
        ("fmi2SetInteger", "gain", -1, "gain = -1, allowed 0 to 2"),
        ("fmi2SetInteger", "begin[3]", 6, "begin[3] = 6, allowed -5 to 5"),
        (
            "fmi2SetReal",
            "begin[1]",
            1,
            "fmi2SetReal: begin[1] is an Integer or an enumeration, use fmi2SetInteger",
        ),
        (
            "fmi2SetReal",
            "gain",
            1,
            "fmi2SetReal: gain is an Integer or an enumeration, use fmi2SetInteger",
        ),
        ("fmi2SetReal", "offset", 1, "fmi2SetReal: offset is a Boolean, use fmi2SetBoolean"),
        ("fmi2SetInteger", "offset", 1, "fmi2SetInteger: offset is a Boolean, use fmi2SetBoolean"),
        (
            "fmi2SetBoolean",
            "gain",
            1,
            "fmi2SetBoolean: gain is an Integer or an enumeration, use fmi2SetInteger",
        ),
        ("fmi2SetInteger", "u", 1, "fmi2SetInteger: u is a Real, use fmi2SetReal"),
        ("fmi2GetInteger", "u", 1, "fmi2GetInteger: u is a Real, use fmi2GetReal"),
        ("fmi2GetReal", "offset", 1, "fmi2GetReal: offset is a Boolean, use fmi2GetBoolean"),
    ],
)
def test_wrong_value_or_function_is_refused(
    typed: Slave, function: str, name: str, value: float, text: str
) -> None:
    everything = [VR[n] for n in ("offset", "gain", "begin[1]", "begin[3]")]
    before = typed.get(everything)
    assert call(typed, function, name, value) == ERROR
    assert typed.said == f"{text} (instance one)"
    assert typed.get(everything) == before


def test_start_value_must_fit_its_type() -> None:
    with pytest.raises(InterfaceError, match=r"begin\[1\] starts at 0.5, must be a whole number"):
        changed(toys.interface(), "begin", type="Integer", start=0.5)
    with pytest.raises(InterfaceError, match="gain starts at 3, allowed 0 to 2"):
        changed(toys.interface(), "gain", type="Enumeration", start=3.0, items=MODES)


def test_fixed_parameter_of_any_type_is_fixed(typed: Slave) -> None:
    assert typed.call("fmi2ExitInitializationMode") == OK
    assert call(typed, "fmi2SetBoolean", "offset", 0) == ERROR
    assert "fmi2SetBoolean: offset is a fixed parameter" in typed.said
