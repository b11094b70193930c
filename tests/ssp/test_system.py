"""Wiring mistakes are found before anything runs, each by name."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface, Variable
from flexhex.ssp.hexapod import hexapod
from flexhex.ssp.system import Component, System
from tests.ssp.toys import ring, source


def blocks(sizes: tuple[int, int, int] = (37, 162, 114)) -> dict[str, Interface]:
    """Interfaces with the hexapod's connectors; sizes: x, p, chi_f."""
    n_x, n_p, n_chi = sizes

    def block(name: str, Ts: float, inputs: str, outputs: str) -> Interface:
        known: dict[str, tuple[str, int | None]] = {
            "payload": ("kg", None), "x": ("1", n_x), "xd": ("1/s", n_x), "xdd": ("1/s2", n_x),
            "p": ("1", n_p), "p_std": ("1", n_p), "chi_f": ("1", n_chi), "z": ("1", 6),
        }  # fmt: skip
        for names, unit in (
            ("r theta theta_f e", "rad"),
            ("rd thetad theta_fd", "rad/s"),
            ("rdd thetadd theta_fdd", "rad/s2"),
            ("tau tau_ff tau_fb tau_f tau_meas innovation", "N m"),
        ):
            known |= {name: (unit, 6) for name in names.split()}
        variables = [
            Variable(name, causality, known[name][0], name, size=known[name][1])
            for causality, names in (("input", inputs), ("output", outputs))
            for name in names.split()
        ]
        return Interface(name, name, Ts, tuple(variables))

    return {
        "reference": block("reference", 0.00025, "", "r rd rdd payload"),
        "plant": block("plant", 0.00025, "tau payload", "theta tau_meas"),
        "feedback": block("feedback", 0.00025, "r theta tau_ff", "tau tau_fb e"),
        "filter": block(
            "filter", 0.0005, "theta tau_meas", "theta_f theta_fd theta_fdd tau_f chi_f"
        ),
        "kinematics": block("kinematics", 0.0005, "theta thetad thetadd", "x xd xdd z"),
        "feedforward": block("feedforward", 0.0005, "x xd xdd z p", "tau_ff"),
        "estimator": block("estimator", 0.03, "x xd xdd chi_f tau_f", "p p_std innovation"),
    }


def test_hexapod_is_the_papers_loop() -> None:
    system = hexapod(blocks())
    assert [c.name for c in system.components] == [
        "reference", "N_F", "F", "feedback", "plant", "W", "N_E", "K",
    ]  # fmt: skip
    assert system.component("N_E").source == system.component("N_F").source == "kinematics.fmu"
    assert [system.steps(c.name) for c in system.components] == [1, 2, 2, 1, 1, 2, 2, 120]
    # 1 payload, 18 of r, 6 r, 3 x 37 + 6 of x and z, p, tau_ff, tau, 3 x 6, 18, 111, 114, 6
    assert len(system.wires) == 1 + 18 + 6 + 117 + 162 + 6 + 6 + 18 + 18 + 111 + 114 + 6
    assert "K.innovation" in system.plots
    assert "K.p_std" not in system.plots


def test_hexapod_instance_overrules_block() -> None:
    other = dataclasses.replace(blocks()["kinematics"], name="other")
    system = hexapod({**blocks(), "N_E": other})
    assert system.component("N_E").source == "other.fmu"
    assert system.component("N_F").source == "kinematics.fmu"


def test_hexapod_missing_block_is_named() -> None:
    without = {name: block for name, block in blocks().items() if name != "filter"}
    with pytest.raises(InterfaceError, match="W: no interface given for the FMU 'filter'"):
        hexapod(without)


WRONG: list[tuple[str, dict[str, Any], str]] = [
    ("unknown component", {"add": ("scr.r", "a.u")}, "no component 'scr', did you mean 'src'"),
    ("unknown variable", {"add": ("src.q", "a.u")}, "in src there is no variable 'q', there are"),
    ("unknown element", {"add": ("src.r[3]", "a.v")}, r"in src there is no variable 'r\[3\]'"),
    ("no dot", {"add": ("src", "a.u")}, "'src' is no `component.variable`"),
    ("sizes", {"add": ("src.r", "a.v")}, "2 values into 1; connect arrays of one size"),
    ("fed twice", {"add": ("src.r[1]", "a.v")}, r"a.v is fed by c.y\[2\] and by src.r\[1\]: keep"),
    ("unfed", {"drop": "a.v"}, "a.v: fed by nothing"),
    ("unfed array", {"drop": "a.u"}, r"a.u\[1\] and 1 more: fed by nothing"),
    ("into output", {"add": ("src.r", "a.y")}, r"a.y\[1\] is of causality output; a connection"),
    ("from input", {"add": ("b.v", "a.v"), "drop": "a.v"}, "b.v is of causality input; a conn"),
    ("from parameter", {"add": ("b.keep", "a.v"), "drop": "a.v"}, "causality parameter"),
    ("plot", {"plots": ("c.nothing",)}, "plot c.nothing: in c there is no variable"),
]


@pytest.mark.parametrize(("what", "change", "text"), WRONG, ids=[w[0] for w in WRONG])
def test_wiring_mistake_is_refused(what: str, change: dict[str, Any], text: str) -> None:
    system = ring()
    connections = [pair for pair in system.connections if pair[1] != change.get("drop")]
    connections += [change["add"]] if "add" in change else []
    with pytest.raises(InterfaceError, match=text):
        dataclasses.replace(
            system, connections=tuple(connections), plots=change.get("plots", system.plots)
        )


def test_unequal_units_are_refused() -> None:
    interfaces = blocks()
    plant = interfaces["plant"]
    wrong = tuple(
        dataclasses.replace(v, unit="m") if v.name == "theta" else v for v in plant.variables
    )
    interfaces["plant"] = dataclasses.replace(plant, variables=wrong)
    with pytest.raises(
        InterfaceError, match=r"plant.theta\[1\] -> feedback.theta\[1\]: m into rad"
    ):
        hexapod(interfaces)


def test_units_of_single_elements_are_compared() -> None:
    interfaces = blocks()
    mixed = ("1",) * 161 + ("N m",)
    K = interfaces["estimator"]
    variables = tuple(
        dataclasses.replace(v, units=mixed) if v.name == "p" else v for v in K.variables
    )
    interfaces["estimator"] = dataclasses.replace(K, variables=variables)
    with pytest.raises(InterfaceError, match=r"K.p\[162\] -> F.p\[162\]: N m into 1"):
        hexapod(interfaces)


@pytest.mark.parametrize("Ts", [0.0006, 0.0001, 0.000250001])
def test_sample_time_that_is_no_whole_number_of_base_steps_is_refused(Ts: float) -> None:
    wrong = dataclasses.replace(source(), Ts=Ts)
    with pytest.raises(InterfaceError, match=r"base steps of 0.00025 s, must be a whole number"):
        System("one", (Component("src", wrong),), ())


def test_component_twice_or_badly_named_is_refused() -> None:
    one = Component("src", source())
    with pytest.raises(InterfaceError, match="'src' exists twice"):
        System("two", (one, one), ())
    with pytest.raises(InterfaceError, match="not a name like"):
        Component("a.b", source())
