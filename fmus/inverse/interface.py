"""Variables and sample time of the FMU of an identified model."""

from __future__ import annotations

import re

from flexhex.fmus.common.interface import Interface, Item, Variable
from flexhex.fmus.inverse.equations import Identified


def interface(name: str, model: Identified, Ts: float) -> Interface:
    """Wanted motion in, torque out; every identified value is a parameter that can be tuned."""
    n, listed = model.n, model.parameters
    rates, accelerations = ([f"{unit}/{per}" for unit in model.positions] for per in ("s", "s2"))

    def axes(called: str, causality: str, units: list[str], what: str) -> Variable:
        return Variable(called, causality, units[0], what, size=n, units=tuple(units))  # type: ignore[arg-type]

    variables = (
        Variable(
            "p",
            "parameter",
            "1",
            "identified parameters",
            size=len(listed),
            start=[one.value for one in listed],
            variability="tunable",
            elements=tuple(structured(one.name) for one in listed),
            units=tuple(one.unit for one in listed),
        ),
        axes("r", "input", list(model.positions), "wanted angles or positions"),
        axes("rd", "input", rates, "their rates"),
        axes("rdd", "input", accelerations, "their accelerations"),
        axes("tau_ff", "output", list(model.efforts), "torque or force that this motion needs"),
    )
    return Interface(
        name,
        "Inverse dynamics of an identified machine: torque of a wanted motion",
        Ts,
        variables,
        {"N": n, "N_P": len(listed), "N_STATES": model.n_states},
        (Item("not_finite", "torque not finite, the last finite torque is shown"),),
    )


def structured(name: str) -> str:
    """A parameter's name as FMI can hold it: `'upper-arm'.m` for `upper-arm.m`."""
    body, dot, last = name.rpartition(".")
    if dot and not re.fullmatch(r"[A-Za-z_]\w*", body, re.ASCII):
        kept = body.replace("\\", "\\\\").replace("'", "\\'")
        body = f"'{kept}'"
    return f"{body}{dot}{last}"
