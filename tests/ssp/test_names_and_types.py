"""Old names get their new one; Booleans, Integers and enumerations in sets, options and results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.fmus.common.errors import FlexhexError, InterfaceError, LogError
from flexhex.ssp.executor import run
from flexhex.ssp.read import read_ssp
from flexhex.ssp.wiring import renamed, unknown
from tests.ssp.archives import edited

SET = "resources/reference.ssv"
KNOWN = ("x_E.x", "x_E.y", "p.actuator[1].o", "p.upper.J[1]", "theta[1]", "theta[2]")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x_E[2]", "x_E.y"),
        ("p[1]", "p.actuator[1].o"),
        ("p[2]", "p.upper.J[1]"),
        ("x_E[3]", ""),
        ("x_E[0]", ""),
        ("theta[2]", ""),
        ("theta[3]", ""),
        ("p.actuator[1]", ""),
    ],
)
def test_counted_element_has_its_new_name(old: str, new: str) -> None:
    assert renamed(old, KNOWN) == new
    assert (f"it is called '{new}'" in unknown("variable", old, KNOWN)) == bool(new)


@pytest.mark.parametrize(
    ("option", "text"),
    [
        ({"parameters": {"plant.actuator[2]": 1.0}}, "it is called 'actuator[1].k'"),
        ({"parameters": {"K.p0[163]": 1.0}}, "there is no name 'p0[163]', did you mean"),
        ({"signals": ["plant.x_E[3]"]}, "it is called 'x_E.z'"),
        ({"signals": ["K.p[1]"]}, "it is called 'p.actuator[1].o'"),
        (
            {"parameters": {"reference.kind": 1.5}},
            "reference.kind = 1.5, must be the whole number of an item",
        ),
        ({"parameters": {"reference.kind": 9}}, "kind = 9, must be one of 0 setpoints, 1 tri"),
        ({"parameters": {"reference.kind": "chrip"}}, "no item 'chrip', did you mean 'chirp'"),
        ({"parameters": {"reference.seed": "three"}}, "seed = three, must be a finite number"),
        ({"parameters": {"feedback.Ts": True}}, "feedback.Ts = True, must be a finite number"),
        ({"parameters": {"W.basis": "maybe"}}, "W.basis = maybe, must be 0, 1, true or false"),
        (
            {"parameters": {"reference.passes": 2.5}},
            "reference.passes = 2.5, must be a whole number",
        ),
        ({"parameters": {"W.basis": 2}}, "basis = 2, allowed 0 to 1"),
        ({"parameters": {"W.basis": 0.5}}, "W.basis = 0.5, must be 0 or 1"),
    ],
)
def test_option_is_refused_in_words(
    hexapod_ssp: Path, option: dict[str, object], text: str
) -> None:
    with pytest.raises(FlexhexError) as caught:
        run(hexapod_ssp, 0.01, **option)  # type: ignore[arg-type]
    assert text in str(caught.value)


def test_old_name_in_a_parameter_set_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    path = edited(
        hexapod_ssp,
        tmp_path / "x.ssp",
        'name="actuator[2].k"',
        'name="actuator[14]"',
        "resources/plant.ssv",
    )
    with pytest.raises(
        InterfaceError, match=r"'actuator\[14\]', it is called 'actuator\[1\]\.b\[5\]'"
    ):
        read_ssp(path)


def test_old_name_in_a_wire_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    path = edited(
        hexapod_ssp, tmp_path / "x.ssp", 'endConnector="p.upper.J[1]"', 'endConnector="p[133]"'
    )
    with pytest.raises(InterfaceError, match=r"'p\[133\]', it is called 'p\.upper\.J\[1\]'"):
        read_ssp(path)


def test_old_name_of_a_result_gets_the_new_one(hexapod_ssp: Path) -> None:
    result = run(hexapod_ssp, 0.01)
    assert np.array_equal(result["plant.x_E.z"], result["plant.x_E"][:, 2])
    with pytest.raises(LogError, match=r"'plant.x_E\[3\]', it is called 'plant.x_E.z'"):
        result["plant.x_E[3]"]


def test_types_in_a_parameter_set(hexapod_ssp: Path, tmp_path: Path) -> None:
    old = '<ssv:Parameter name="kind">\n      <ssv:Integer value="0"/>'

    def written(name: str, entry: str) -> Path:
        return edited(hexapod_ssp, tmp_path / name, old, f'<ssv:Parameter name="kind">{entry}', SET)

    by_name = written("a.ssp", '<ssv:Enumeration value="chirp"/>')
    assert read_ssp(by_name).instance("reference").parameters["kind"] == 3
    with pytest.raises(InterfaceError, match=r"there is no item 'chrip', did you mean 'chirp'"):
        read_ssp(written("b.ssp", '<ssv:Enumeration value="chrip"/>'))
    with pytest.raises(InterfaceError, match=r"kind = 0.5, must be the whole number of an item"):
        read_ssp(written("c.ssp", '<ssv:Real value="0.5"/>'))


def test_values_of_all_types_are_logged(hexapod_ssp: Path) -> None:
    result = run(hexapod_ssp, 0.1, signals=["N_F.converged", "N_F.fault", "plant.end_stop"])
    assert set(result["N_F.converged"]) == {1.0}
    assert set(result["plant.end_stop"]) == set(result["N_F.fault"]) == {0.0}


@pytest.mark.parametrize(
    ("value", "number"),
    [("chirp", 3), ("3", 3), (3, 3), (np.int64(3), 3), (np.array(3.0), 3)],
    ids=["item", "text", "number", "numpy", "array"],
)
def test_enumeration_is_set_by_item_or_number(hexapod_ssp: Path, value: Any, number: float) -> None:
    result = run(hexapod_ssp, 0.001, parameters={"reference.kind": value})
    assert result.meta["parameter reference.kind"] == number


@pytest.mark.parametrize(
    ("value", "number"), [(False, 0), (True, 1), ("false", 0), ("True", 1), (0, 0), ("1", 1)]
)
def test_boolean_is_set_by_word_or_number(hexapod_ssp: Path, value: Any, number: float) -> None:
    result = run(hexapod_ssp, 0.001, parameters={"W.basis": value})
    assert result.meta["parameter W.basis"] == number
