"""Tries an FMU's binary: `python -m flexhex.check.exercise` in a process of its own.

Reads the plan (JSON) from stdin; writes one JSON pair a line: ["doing", what], before each trial,
so that a crash can be named, ["complaint", text] and ["note", text].
"""

from __future__ import annotations

import ctypes as ct
import json
import math
import sys
from collections.abc import Callable, Iterator
from typing import Any

from flexhex.check import claims, trials
from flexhex.check.slave import FUNCTIONS, Instance, RefusedError


def say(kind: str, text: str) -> None:
    """One line to the parent, at once."""
    print(json.dumps([kind, text]), flush=True)


def identity(library: Any, plan: dict[str, Any]) -> Iterator[str]:
    """Version, platform, functions; whether the binary knows the description's GUID."""
    library.fmi2GetVersion.restype = library.fmi2GetTypesPlatform.restype = ct.c_char_p
    if library.fmi2GetVersion() != b"2.0":
        yield f"the binary says FMI {library.fmi2GetVersion()!r}, the description 2.0"
    if library.fmi2GetTypesPlatform() != b"default":
        yield f"types platform {library.fmi2GetTypesPlatform()!r}, importers expect 'default'"
    instance = Instance(library, plan)
    if not instance.c:
        raise RefusedError(f"the binary refuses to be instantiated{instance.last}")
    if plan["flags"].get("canNotUseMemoryManagementFunctions") and instance.allocated:
        yield "canNotUseMemoryManagementFunctions is true, but it uses them"
    instance.free()
    if plan["ours"]:
        stranger = Instance(library, plan, "{00000000-0000-0000-0000-000000000000}")
        if stranger.c:
            yield "the binary takes any GUID: one of another build would not be noticed"


def play(library: Any, plan: dict[str, Any]) -> None:
    """Outputs after each step with the inputs of plan["play"], one line ["row", values] each."""
    given = plan["play"]
    instance = Instance(library, plan)
    if not instance.c or not instance.initialise():
        say("complaint", f"cannot be initialised{instance.last}")
        return
    for k, row in enumerate(given["rows"]):
        time, end = given["times"][k], given["times"][k + 1]
        taken = instance.set(given["inputs"], row) if row else True
        done = taken and instance.step(time, end - time)
        values = instance.get(given["outputs"]) if done else None
        if values is None:
            say("complaint", f"step {k + 1} is refused{instance.last}")
            return
        print(json.dumps(["row", values]), flush=True)
    instance.free()


TRIALS: tuple[Callable[[Any, dict[str, Any]], Iterator[str]], ...] = (
    identity,
    trials.starts,
    trials.steps,
    trials.step_sizes,
    trials.fresh_after_reset,
    trials.instances,
    trials.states,
    claims.derivatives,
    claims.dependencies,
    claims.first_dependencies,
    claims.categories,
    claims.refusals,
    claims.parameters,
    claims.changes,
)


def main() -> None:
    """Run all trials of the plan on stdin."""
    plan = json.load(sys.stdin, parse_constant=lambda text: math.nan)
    say("doing", "loading the binary")
    try:
        library = ct.CDLL(plan["library"])
    except OSError as error:
        say("complaint" if plan["ours"] else "note", f"the binary cannot be loaded: {error}")
        return
    missing = [name for name in FUNCTIONS if not hasattr(library, name)]
    if missing:
        say("complaint", f"the binary lacks {', '.join(missing)}")
        return
    if "play" in plan:
        play(library, plan)
        return
    for trial in TRIALS:
        say("doing", (trial.__doc__ or trial.__name__).splitlines()[0].rstrip("."))
        try:
            for text in trial(library, plan):
                say("complaint", text)
        except RefusedError as error:
            say("complaint", str(error))
            return


if __name__ == "__main__":
    main()
