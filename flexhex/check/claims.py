"""Trials of what a description claims beyond the basics: derivatives, dependencies, log categories.

Generators of complaints, as in `trials`.
"""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Iterator
from typing import Any

from flexhex.check.slave import Instance, Place
from flexhex.check.trials import MOST, TrialPlan, course, initialised, moved, of, same


def derivatives(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Derivatives of all kinds, as far as the flags promise them."""
    flags, instance, one = plan["flags"], initialised(library, plan), ct.c_size_t(1)
    course(instance, plan, 0, 1)
    inputs, outputs = (
        [v["reference"][1] for v in of(plan, causality) if v["type"] == "Real"]
        for causality in ("input", "output")
    )
    if not inputs or not outputs:
        instance.free()
        return
    u, y = ((ct.c_uint * 1)(references[0]) for references in (inputs, outputs))
    value, order = (ct.c_double * 1)(1.0), (ct.c_int * 1)(1)
    promises: dict[str, tuple[str, tuple[object, ...]]] = {
        "providesDirectionalDerivative": (
            "fmi2GetDirectionalDerivative",
            (y, one, u, one, value, value),
        ),
        "canInterpolateInputs": ("fmi2SetRealInputDerivatives", (u, one, order, value)),
        "maxOutputDerivativeOrder": ("fmi2GetRealOutputDerivatives", (y, one, order, value)),
    }
    for flag, (function, arguments) in promises.items():
        if flags.get(flag) and instance.call(function, *arguments) > 1:
            yield f"{flag} is promised, but {function} is refused{instance.last}"
    instance.free()


def dependencies(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Outputs change with inputs of the same instant only where the description says so."""
    instance, outputs = initialised(library, plan), of(plan, "output")
    course(instance, plan, 0, 2)
    references = [v["reference"] for v in outputs]
    for v in of(plan, "input")[:MOST]:
        before = instance.get(references)
        instance.set([v["reference"]], [moved(v, 4)])
        after = instance.get(references)
        for y, a, b in zip(outputs, before or [], after or [], strict=False):
            declared = plan["dependencies"].get(y["name"])
            if not same(a, b) and declared is not None and v["name"] not in declared:
                yield f"{y['name']} depends on {v['name']}, ModelStructure/Outputs says no"
    instance.free()


def first_dependencies(library: Any, plan: TrialPlan) -> Iterator[str]:
    """First outputs change only with what InitialUnknowns names."""
    instance, outputs = Instance(library, plan), of(plan, "output")
    references = [v["reference"] for v in outputs]
    seen: list[list[float] | None] = []
    instance.initialise(lambda: seen.append(instance.get(references)))
    for v in of(plan, "parameter", "input")[:MOST]:
        if instance.call("fmi2Reset") > 1:
            break
        instance.initialise(lambda v=v: _change(instance, v, references, seen))  # type: ignore[misc]
        for y, a, b in zip(outputs, seen[0] or [], seen[-1] or [], strict=False):
            declared = plan["initial"].get(y["name"])
            if not same(a, b) and declared is not None and v["name"] not in declared:
                yield f"the first {y['name']} depends on {v['name']}, InitialUnknowns says no"
    instance.free()


def _change(
    instance: Instance, v: dict[str, Any], references: list[Place], seen: list[list[float] | None]
) -> None:
    """Outputs after another start value; a value that the FMU refuses tells nothing."""
    taken = instance.set([v["reference"]], [moved(v, 4)])
    seen.append(instance.get(references) if taken else None)


def categories(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Log categories can be chosen, and no other one is used."""
    instance, declared = Instance(library, plan), plan["categories"]
    for name in declared:
        one = (ct.c_char_p * 1)(name.encode())
        if instance.call("fmi2SetDebugLogging", 1, ct.c_size_t(1), one) > 1:
            yield f"log category {name} is declared, but cannot be switched on"
    instance.call("fmi2SetDebugLogging", 1, ct.c_size_t(0), None)
    instance.initialise()
    course(instance, plan, 0, 2)
    for name in sorted({category for _, category, _ in instance.said} - set(declared)):
        if declared:
            yield f"it logs to category {name or '(empty)'}, which is not declared"
    instance.free()


def refusals(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Values that are no numbers or out of range are refused, and shown by `fault`."""
    if not plan["ours"]:
        return
    instance = initialised(library, plan)
    fault = next(v["reference"] for v in of(plan, "output") if v["name"] == "fault")
    for v in (v for v in of(plan, "input") if v["type"] == "Real"):
        wrong = [math.nan, math.inf, -math.inf]
        wrong += [math.nextafter(v["max"], math.inf)] if v["max"] is not None else []
        wrong += [math.nextafter(v["min"], -math.inf)] if v["min"] is not None else []
        for value in wrong:
            before = instance.get([v["reference"]])
            if instance.set([v["reference"]], [value]) or instance.get([v["reference"]]) != before:
                yield f"{v['name']} = {value} is taken, declared {v['min']} to {v['max']}"
            elif not (instance.get([fault]) or [0.0])[0]:
                yield f"{v['name']} = {value} is refused, but fault does not show it"
    instance.free()


def parameters(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Parameters take the values from min to max, and no others."""
    if not plan["ours"]:
        return
    instance = Instance(library, plan)
    for v in (v for v in of(plan, "parameter") if v["type"] != "Boolean"):
        for end, beyond in (("min", -math.inf), ("max", math.inf)):
            value = v[end]
            if value is None:
                continue
            if not instance.set([v["reference"]], [value]):
                yield f"{v['name']} = {value:.9g}, its {end}, is refused{instance.last}"
            further = math.nextafter(value, beyond)
            if v["type"] == "Integer":
                further = value + math.copysign(1, beyond)
            if instance.set([v["reference"]], [further]):
                yield f"{v['name']} = {further:.17g} is taken, declared {end} {value:.9g}"
    instance.free()


def changes(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Tunable parameters can be changed while it runs; of ours the fixed ones cannot."""
    instance = initialised(library, plan)
    course(instance, plan, 0, 1)
    for v in of(plan, "parameter"):
        taken = instance.set([v["reference"]], [v["start"]])
        if v["variability"] == "tunable" and not taken:
            yield f"{v['name']} is tunable, but cannot be set while it runs{instance.last}"
        elif v["variability"] == "fixed" and taken and plan["ours"]:
            yield f"{v['name']} is fixed, but can be set while it runs"
    instance.free()
