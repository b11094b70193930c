"""An FMU binary through plain ctypes: every function of FMI 2.0 as the standard declares it."""

from __future__ import annotations

import ctypes as ct
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from lxml import etree

OK, WARNING, DISCARD, ERROR = 0, 1, 2, 3
NUMBERS: dict[str, Any] = {"Real": ct.c_double, "Integer": ct.c_int, "Boolean": ct.c_int}
"""What the functions of FMI pass."""
KINDS = {kind: kind for kind in NUMBERS} | {"Enumeration": "Integer"}
Logger = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_char_p, ct.c_int, ct.c_char_p, ct.c_char_p)
Allocate = ct.CFUNCTYPE(ct.c_void_p, ct.c_size_t, ct.c_size_t)
Free = ct.CFUNCTYPE(None, ct.c_void_p)


class Callbacks(ct.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", Logger),
        ("allocateMemory", ct.c_void_p),
        ("freeMemory", ct.c_void_p),
        ("stepFinished", ct.c_void_p),
        ("environment", ct.c_void_p),
    )


class Binary:
    """A loaded FMU: the library, GUID and name from the archive."""

    def __init__(self, fmu: Path, folder: Path) -> None:
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        self.folder = folder
        self.xml = etree.parse(str(folder / "modelDescription.xml")).getroot()
        self.kinds = {
            int(v.get("valueReference")): KINDS[v[0].tag] for v in self.xml.iter("ScalarVariable")
        }
        self.name = str(self.xml.get("modelName"))
        self.guid = str(self.xml.get("guid"))
        self.library = ct.CDLL(str(folder / "binaries" / "linux64" / f"{self.name}.so"))
        self.library.fmi2Instantiate.restype = ct.c_void_p
        for text in ("fmi2GetVersion", "fmi2GetTypesPlatform"):
            getattr(self.library, text).restype = ct.c_char_p
        self.library.fmi2FreeInstance.restype = None


class Slave:
    """One instance; `log` collects (status, category, message)."""

    def __init__(
        self,
        binary: Binary,
        name: str = "one",
        *,
        guid: str | None = None,
        kind: int = 1,
        logging: bool = False,
        memory: tuple[object, object] | None = None,
    ) -> None:
        self.binary, self.library = binary, binary.library
        self.log: list[tuple[int, str, str]] = []
        self._logger = Logger(self._hear)
        self.callbacks = Callbacks(logger=self._logger)
        if memory:
            self._memory = memory
            self.callbacks.allocateMemory = ct.cast(memory[0], ct.c_void_p)  # type: ignore[arg-type]
            self.callbacks.freeMemory = ct.cast(memory[1], ct.c_void_p)  # type: ignore[arg-type]
        text = binary.guid if guid is None else guid
        self.c = self.library.fmi2Instantiate(
            name.encode(), kind, text.encode(), None, ct.byref(self.callbacks), 0, int(logging)
        )
        self.n = 0

    def _hear(self, _env: int, _name: bytes, status: int, category: bytes, text: bytes) -> None:
        self.log.append((status, category.decode(), text.decode()))

    @property
    def said(self) -> str:
        """The last message."""
        return self.log[-1][2] if self.log else ""

    def call(self, function: str, *arguments: object) -> int:
        """Status of a function of the library."""
        return int(self.library[function](ct.c_void_p(self.c), *arguments))

    def initialise(self, stop: float | None = None, start: float = 0.0) -> Slave:
        """Bring it to the first step; all calls must succeed."""
        assert self.setup(start, stop) == OK
        assert self.call("fmi2EnterInitializationMode") == OK
        assert self.call("fmi2ExitInitializationMode") == OK, self.said
        return self

    def setup(self, start: float = 0.0, stop: float | None = None) -> int:
        """fmi2SetupExperiment without a tolerance."""
        stops = (0, ct.c_double(0)) if stop is None else (1, ct.c_double(stop))
        return self.call("fmi2SetupExperiment", 0, ct.c_double(0), ct.c_double(start), *stops)

    def set(self, references: Sequence[int], values: Iterable[float]) -> int:
        """fmi2SetReal, fmi2SetInteger, fmi2SetBoolean by the variables' types: worst status."""
        given, worst = dict(zip(references, values, strict=True)), OK
        for kind, vr, _ in self._by_kind(references):
            plain = float if kind == "Real" else int
            numbers = (NUMBERS[kind] * len(vr))(*(plain(given[k]) for k in vr))
            worst = max(worst, self.call(f"fmi2Set{kind}", vr, ct.c_size_t(len(vr)), numbers))
        return worst

    def get(self, references: Sequence[int]) -> list[float]:
        """fmi2GetReal and the others, which must succeed."""
        status, values = self.try_get(references)
        assert status == OK, self.said
        return values

    def try_get(self, references: Sequence[int]) -> tuple[int, list[float]]:
        """fmi2GetReal and the others: worst status, and values, -77 for what was not written."""
        values, worst = [-77.0] * len(references), OK
        for kind, vr, at in self._by_kind(references):
            numbers = (NUMBERS[kind] * len(vr))(*[-77] * len(vr))
            worst = max(worst, self.call(f"fmi2Get{kind}", vr, ct.c_size_t(len(vr)), numbers))
            for k, value in zip(at, numbers, strict=True):
                values[k] = float(value)
        return worst, values

    def _by_kind(self, references: Sequence[int]) -> Iterator[tuple[str, Any, list[int]]]:
        """References by the function that takes them, with their places; unknown ones are Reals."""
        kinds = [self.binary.kinds.get(k, "Real") for k in references]
        for kind in dict.fromkeys(kinds):
            at = [k for k, other in enumerate(kinds) if other == kind]
            yield kind, (ct.c_uint * len(at))(*(references[k] for k in at)), at

    def step(self, time: float, size: float) -> int:
        """fmi2DoStep."""
        return self.call("fmi2DoStep", ct.c_double(time), ct.c_double(size), 1)

    def advance(self, count: int = 1, base: float = 0.00025) -> None:
        """A good step of `count` base steps from where the instance is."""
        assert self.step(self.n * base, count * base) == OK, self.said
        self.n += count

    def state(self) -> ct.c_void_p:
        """fmi2GetFMUstate into a new state."""
        state = ct.c_void_p()
        assert self.call("fmi2GetFMUstate", ct.byref(state)) == OK, self.said
        return state

    def restore(self, state: ct.c_void_p) -> int:
        """fmi2SetFMUstate."""
        return self.call("fmi2SetFMUstate", state)

    def forget(self, state: ct.c_void_p) -> int:
        """fmi2FreeFMUstate."""
        return self.call("fmi2FreeFMUstate", ct.byref(state))

    def serialised(self) -> bytes:
        """The present state as bytes."""
        state, size = self.state(), ct.c_size_t()
        assert self.call("fmi2SerializedFMUstateSize", state, ct.byref(size)) == OK
        buffer = (ct.c_char * size.value)()
        assert self.call("fmi2SerializeFMUstate", state, buffer, size) == OK
        assert self.forget(state) == OK
        return bytes(buffer)

    def deserialise(self, data: bytes) -> tuple[int, ct.c_void_p]:
        """fmi2DeSerializeFMUstate: status and the state."""
        state = ct.c_void_p()
        buffer = (ct.c_char * max(len(data), 1)).from_buffer_copy(data or b"\0")
        size = ct.c_size_t(len(data))
        return self.call("fmi2DeSerializeFMUstate", buffer, size, ct.byref(state)), state

    def free(self) -> None:
        """fmi2FreeInstance."""
        self.call_free()
        self.c = None

    def call_free(self) -> None:
        """fmi2FreeInstance; the pointer is kept."""
        self.library.fmi2FreeInstance(ct.c_void_p(self.c))
