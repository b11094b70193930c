"""Trials of an FMU's binary, each a generator of complaints, all on fresh instances.

A plan (made by `check_binary`) holds the declared flags, variables, dependencies and a step size.
"""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Iterator
from typing import Any

from flexhex.check.slave import Instance, RefusedError

TrialPlan = dict[str, Any]
STEPS = 5
MOST = 200
"""Parameters and inputs that are varied one by one, at most."""


def of(plan: TrialPlan, *causalities: str) -> list[dict[str, Any]]:
    """The variables of these causalities, Strings left out."""
    return [v for v in plan["variables"] if v["causality"] in causalities]


def moved(v: dict[str, Any], k: int) -> float:
    """A value of a variable near its start and within its range, another for each k."""
    if v["type"] != "Real":
        return float(v["start"])
    low, high, start = v["min"], v["max"], v["start"]
    low = -1e300 if low is None else low
    high = 1e300 if high is None else high
    size = min(0.05 * max(abs(start), 1e-2), 0.25 * (high - low))
    shift = size * (0.3 + 0.1 * (k % 5))
    near = start + shift if start + shift <= high else start - shift
    return float(min(max(near, low), high))


def initialised(library: Any, plan: TrialPlan) -> Instance:
    """An instance ready to step."""
    instance = Instance(library, plan)
    instance.initialise()
    return instance


def course(instance: Instance, plan: TrialPlan, first: int, count: int) -> list[list[float] | None]:
    """Outputs after each of `count` steps with moving inputs, as the step number `first` on."""
    h, seen, outputs = plan["step"], [], [v["reference"] for v in of(plan, "output")]
    inputs = of(plan, "input")
    for k in range(first, first + count):
        instance.set([v["reference"] for v in inputs], [moved(v, k) for v in inputs])
        if not instance.step(plan["start"] + k * h, h):
            break
        seen.append(instance.get(outputs))
    return seen


def same(a: object, b: object) -> bool:
    """Equal to the last bit; nan equals nan."""
    return repr(a) == repr(b)


def starts(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Start values are those of the description."""
    instance, values = Instance(library, plan), []
    listed = of(plan, "parameter", "input")

    def look() -> None:
        values.append(instance.get([v["reference"] for v in listed]))

    if not instance.initialise(look):
        yield f"cannot be initialised with its own start values{instance.last}"
    for v, value in zip(listed, values[0] or [], strict=False):
        if not math.isclose(value, v["start"], rel_tol=1e-12, abs_tol=1e-300):
            yield f"{v['name']} starts at {value:.17g} in the binary, {v['start']:.17g} declared"
    _all_readable(instance, plan)
    instance.free()


def _all_readable(instance: Instance, plan: TrialPlan) -> None:
    """RefusedError that names a variable that cannot be read."""
    listed = plan["variables"]
    if instance.c and instance.get([v["reference"] for v in listed]) is None:
        lost = next((v for v in listed if instance.get([v["reference"]]) is None), None)
        name = f"{lost['name']} cannot be read" if lost else "variables can be read one by one only"
        raise RefusedError(f"{name}{instance.last}")


def steps(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Steps of the default size, outputs within their ranges."""
    instance = initialised(library, plan)
    seen = course(instance, plan, 0, STEPS)
    if len(seen) < STEPS:
        yield f"step {len(seen) + 1} of {plan['step']:.9g} s is refused{instance.last}"
    for row in seen:
        for v, value in zip(of(plan, "output"), row or [], strict=False):
            low = -math.inf if v["min"] is None else v["min"]
            high = math.inf if v["max"] is None else v["max"]
            if value < low or value > high:
                yield f"{v['name']} = {value:.9g}, declared {low:.9g} to {high:.9g}"
            if plan["ours"] and not math.isfinite(value):
                yield f"{v['name']} = {value} after ordinary steps"
    instance.free()


def step_sizes(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Steps of other sizes, when canHandleVariableCommunicationStepSize is true."""
    if not plan["flags"].get("canHandleVariableCommunicationStepSize"):
        return
    instance, h, time = initialised(library, plan), plan["step"], float(plan["start"])
    for count in (1, 2, 1, 3):
        if not instance.step(time, count * h):
            yield f"canHandleVariableCommunicationStepSize is true, but not so{instance.last}"
            break
        time += count * h
    instance.free()


def fresh_after_reset(library: Any, plan: TrialPlan) -> Iterator[str]:
    """After fmi2Reset everything is as in a fresh instance."""
    instance = initialised(library, plan)
    once = course(instance, plan, 0, STEPS)
    if instance.call("fmi2Reset") > 1:
        yield f"fmi2Reset is refused{instance.last}"
    elif not instance.initialise() or not same(course(instance, plan, 0, STEPS), once):
        yield "after fmi2Reset it runs otherwise than a fresh instance"
    instance.free()


def instances(library: Any, plan: TrialPlan) -> Iterator[str]:
    """Two instances side by side, unless canBeInstantiatedOnlyOncePerProcess is true."""
    if plan["flags"].get("canBeInstantiatedOnlyOncePerProcess"):
        return
    alone = initialised(library, plan)
    wanted = course(alone, plan, 0, STEPS)
    alone.free()
    one, two = initialised(library, plan), Instance(library, plan)
    if not two.c:
        yield "canBeInstantiatedOnlyOncePerProcess is false, but a second instance is refused"
        one.free()
        return
    two.initialise()
    seen = []
    for k in range(STEPS):
        seen += course(one, plan, k, 1)
        course(two, plan, k, 1)
    if not same(seen, wanted):
        yield "an instance runs otherwise when there is another one"
    one.free()
    two.free()


def states(library: Any, plan: TrialPlan) -> Iterator[str]:
    """FMU states bring back what they hold, in memory and as bytes, as the flags say."""
    if not plan["flags"].get("canGetAndSetFMUstate"):
        return
    instance, state = initialised(library, plan), ct.c_void_p()
    course(instance, plan, 0, STEPS)
    if instance.call("fmi2GetFMUstate", ct.byref(state)) > 1:
        yield f"canGetAndSetFMUstate is true, but not so{instance.last}"
        return
    first = course(instance, plan, STEPS, STEPS)
    if instance.call("fmi2SetFMUstate", state) > 1 or not same(
        course(instance, plan, STEPS, STEPS), first
    ):
        yield "canGetAndSetFMUstate is true, but a state does not bring everything back"
    if plan["flags"].get("canSerializeFMUstate"):
        text = _bytes(instance, plan, state, first)
        if text:
            yield text
    instance.call("fmi2FreeFMUstate", ct.byref(state))
    instance.free()


def _bytes(instance: Instance, plan: TrialPlan, state: ct.c_void_p, first: object) -> str:
    """The complaint about a state as bytes, empty when all is well."""
    size, copy = ct.c_size_t(), ct.c_void_p()
    if instance.call("fmi2SerializedFMUstateSize", state, ct.byref(size)) > 1:
        return f"canSerializeFMUstate is true, but not so{instance.last}"
    data = (ct.c_char * max(size.value, 1))()
    if instance.call("fmi2SerializeFMUstate", state, data, size) > 1:
        return f"canSerializeFMUstate is true, but not so{instance.last}"
    if instance.call("fmi2DeSerializeFMUstate", data, size, ct.byref(copy)) > 1:
        return f"canSerializeFMUstate is true, but its own bytes are refused{instance.last}"
    if instance.call("fmi2SetFMUstate", copy) > 1 or not same(
        course(instance, plan, STEPS, STEPS), first
    ):
        return "canSerializeFMUstate is true, but the bytes do not bring everything back"
    instance.call("fmi2FreeFMUstate", ct.byref(copy))
    if plan["ours"] and size.value:
        data[size.value - 1] = bytes([data[size.value - 1][0] ^ 1])
        if instance.call("fmi2DeSerializeFMUstate", data, size, ct.byref(copy)) <= 1:
            return "damaged bytes of a state are taken"
    return ""
