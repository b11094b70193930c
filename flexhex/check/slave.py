"""An FMI 2.0 co-simulation library through plain ctypes, for the child process of the checks."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable, Sequence
from typing import Any

OK = 0
Place = Sequence[Any]
"""FMI's function for a variable, a key of NUMBERS, and its value reference."""
NUMBERS: dict[str, Any] = {"Real": ct.c_double, "Integer": ct.c_int, "Boolean": ct.c_int}
"""What FMI's functions pass."""
Logger = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_char_p, ct.c_int, ct.c_char_p, ct.c_char_p)
Allocate = ct.CFUNCTYPE(ct.c_void_p, ct.c_size_t, ct.c_size_t)
Free = ct.CFUNCTYPE(None, ct.c_void_p)
NAMES = [
    "fmi2GetTypesPlatform fmi2GetVersion fmi2SetDebugLogging fmi2Instantiate fmi2FreeInstance",
    "fmi2SetupExperiment fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate",
    "fmi2Reset fmi2GetReal fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2SetReal",
    "fmi2SetInteger fmi2SetBoolean fmi2SetString fmi2GetFMUstate fmi2SetFMUstate",
    "fmi2FreeFMUstate fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives",
    "fmi2DoStep fmi2CancelStep fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus",
    "fmi2GetBooleanStatus fmi2GetStringStatus",
]
FUNCTIONS = " ".join(NAMES).split()
"""All functions that a co-simulation FMU exports."""


class RefusedError(Exception):
    """Nothing further can be tried."""


class Callbacks(ct.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", Logger),
        ("allocateMemory", Allocate),
        ("freeMemory", Free),
        ("stepFinished", ct.c_void_p),
        ("environment", ct.c_void_p),
    )


class Instance:
    """One instance; `c` is None when it was refused. Variables are read and set by place."""

    def __init__(self, library: Any, plan: dict[str, Any], guid: str | None = None) -> None:
        self.library, self.plan = library, plan
        self.said: list[tuple[int, str, str]] = []
        self.allocated = 0
        libc = ct.CDLL(None)
        libc.calloc.restype, libc.free.argtypes = ct.c_void_p, [ct.c_void_p]

        def allocate(count: int, size: int) -> int | None:
            self.allocated += 1
            memory: int | None = libc.calloc(ct.c_size_t(count), ct.c_size_t(size))
            return memory

        def hear(_: int, __: bytes, status: int, category: bytes, text: bytes) -> None:
            decoded = [(b or b"").decode(errors="replace") for b in (category, text)]
            self.said.append((status, decoded[0], decoded[1]))

        self.callbacks = Callbacks(Logger(hear), Allocate(allocate), Free(libc.free))
        library.fmi2Instantiate.restype = ct.c_void_p
        library.fmi2FreeInstance.restype = None
        self.c = library.fmi2Instantiate(
            b"flexhex_check",
            1,
            (plan["guid"] if guid is None else guid).encode(),
            plan["resources"].encode(),
            ct.byref(self.callbacks),
            0,
            0,
        )

    @property
    def last(self) -> str:
        """What the FMU said last, in brackets, for a complaint."""
        return f" ({self.said[-1][2]})" if self.said else ""

    def call(self, function: str, *arguments: object) -> int:
        """Status of a function."""
        return int(self.library[function](ct.c_void_p(self.c), *arguments))

    def initialise(self, within: Callable[[], None] = lambda: None) -> bool:
        """Set up and initialise; `within` is called in initialization mode. True: all was ok."""
        start = float(self.plan["start"])
        worst = self.call(
            "fmi2SetupExperiment", 0, ct.c_double(0), ct.c_double(start), 0, ct.c_double(0)
        )
        worst = max(worst, self.call("fmi2EnterInitializationMode"))
        within()
        return max(worst, self.call("fmi2ExitInitializationMode")) <= 1

    def get(self, places: Sequence[Place]) -> list[float] | None:
        """Values of variables; None when the FMU refused."""
        numbers = [0.0] * len(places)
        for suffix, number in NUMBERS.items():
            mine = [k for k, (kind, _) in enumerate(places) if kind == suffix]
            n, values = len(mine), (number * max(len(mine), 1))()
            vr = (ct.c_uint * max(n, 1))(*(places[k][1] for k in mine))
            if n and self.call(f"fmi2Get{suffix}", vr, ct.c_size_t(n), values) > 1:
                return None
            for k, value in zip(mine, values, strict=False):
                numbers[k] = float(value)
        return numbers

    def set(self, places: Sequence[Place], values: Sequence[float]) -> bool:
        """Set variables; True when the FMU took them."""
        for suffix, number in NUMBERS.items():
            mine = [k for k, (kind, _) in enumerate(places) if kind == suffix]
            vr = (ct.c_uint * max(len(mine), 1))(*(places[k][1] for k in mine))
            plain = float if number is ct.c_double else int
            numbers = (number * max(len(mine), 1))(*(plain(values[k]) for k in mine))
            if mine and self.call(f"fmi2Set{suffix}", vr, ct.c_size_t(len(mine)), numbers) > 1:
                return False
        return True

    def step(self, time: float, size: float) -> bool:
        """One communication step; True when it was complete."""
        return self.call("fmi2DoStep", ct.c_double(time), ct.c_double(size), 1) <= 1

    def free(self) -> None:
        """Give the instance back."""
        self.library.fmi2FreeInstance(ct.c_void_p(self.c))
