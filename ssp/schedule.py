"""The schedule of a system as the C executor wants it, and one run of it."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_size_t, c_uint
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.fmus.common.archive import open_zip, read_member
from flexhex.fmus.common.errors import InterfaceError, RunError
from flexhex.fmus.common.interface import indices
from flexhex.ssp import library
from flexhex.ssp.fmu import FmuVariable, binary_path
from flexhex.ssp.memory import check_memory
from flexhex.ssp.played import Played
from flexhex.ssp.read import Instance, Package, period
from flexhex.ssp.results import Array, FmuTime, Group, rate_name
from flexhex.ssp.signals import LoggedVariable

TYPES = (("Real",), ("Integer", "Enumeration"), ("Boolean",))
"""What the executor passes by one function of FMI, in the order of its variables."""
Progress = Callable[[float, float], None]
_CATEGORIES = ("logStatusError", "logStatusWarning")


class Schedule:
    """The schedule as the C executor wants it; keeps alive what its structures point to."""

    def __init__(
        self,
        package: Package,
        overrides: Mapping[str, dict[str, float]],
        logged: Mapping[str, list[LoggedVariable]],
        played: Played,
        folder: Path,
    ) -> None:
        self.package = package
        self.played = played
        self.logged = logged
        self.keep: list[Any] = []
        self.times: dict[str, FmuTime] = {}
        self.buffers: dict[int, Array] = {}
        self.periods = {
            i.name: period(i, package.base, overrides[i.name]) for i in package.instances
        }
        self.slots = self._bus()
        roots = _extract(package, folder)
        self.components = [
            self._component(i, roots[i.source], {**i.parameters, **overrides[i.name]})
            for i in package.instances
        ]

    def _bus(self) -> dict[tuple[str, str], int]:
        """A slot for every output that is connected or logged, by component and type."""
        used = {(w.source, w.output) for w in self.package.wires}
        for name, signals in self.logged.items():
            used |= {(name, v.name) for s in signals for v in s.scalars}
        instances = self.package.instances
        ends = [(i.name, v.name) for i in instances for v in by_type(i.fmu.of("output"))]
        return {end: slot for slot, end in enumerate(end for end in ends if end in used)}

    def _array(self, kind: Any, values: Sequence[Any]) -> Any:
        array = (kind * max(len(values), 1))(*values)
        self.keep.append(array)
        return array

    def _variables(self, listed: Sequence[FmuVariable]) -> library.Variables:
        counts = (sum(v.type in types for v in listed) for types in TYPES)
        return library.Variables(*counts, self._array(c_uint, [v.reference for v in listed]))

    def _component(
        self, instance: Instance, root: Path, values: Mapping[str, float]
    ) -> library.ComponentData:
        variables, name = instance.fmu.variables, instance.name
        parameters = by_type([variables[v] for v in values])
        wires = [w for w in self.package.wires if w.target == name]
        sources = {w.input: self.slots[w.source, w.output] for w in wires}
        own = enumerate(self.played.ends, len(self.slots))
        sources |= {scalar: slot for slot, (target, scalar) in own if target == name}
        inputs = by_type([variables[v] for v in sources])
        outputs = by_type([v for v in instance.fmu.of("output") if (name, v.name) in self.slots])
        categories = [c.encode() for c in _CATEGORIES if c in instance.fmu.log_categories]
        return library.ComponentData(
            name=name.encode(),
            library=str(root / binary_path(instance.fmu.model)).encode(),
            guid=instance.fmu.guid.encode(),
            resources=(root / "resources").as_uri().encode(),
            period=self.periods[name],
            parameters=self._variables(parameters),
            values=self._array(c_double, [values[v.name] for v in parameters]),
            inputs=self._variables(inputs),
            sources=self._array(c_size_t, [sources[v.name] for v in inputs]),
            outputs=self._variables(outputs),
            slot=self.slots[name, outputs[0].name] if outputs else 0,
            n_categories=len(categories),
            categories=self._array(ctypes.c_char_p, categories),
        )

    def _columns(self) -> dict[int, list[tuple[str, LoggedVariable]]]:
        """Logged signals by period."""
        columns: dict[int, list[tuple[str, LoggedVariable]]] = {}
        for name, signals in self.logged.items():
            if signals:
                columns.setdefault(self.periods[name], []).extend((name, s) for s in signals)
        return dict(sorted(columns.items()))

    def _logs(self, n_steps: int) -> Any:
        logs = []
        for steps, columns in self._columns().items():
            slots = [self.slots[name, v.name] for name, s in columns for v in s.scalars]
            rows = np.zeros((n_steps // steps + 1, len(slots)))
            self.buffers[steps] = rows
            array = self._array(c_size_t, slots)
            logs.append(library.LogData(steps, len(slots), array, rows.ctypes.data, len(rows), 0))
        return self._array(library.LogData, logs), len(logs)

    def execute(self, c: Any, n_steps: int, progress: Progress | None, timing: bool) -> None:
        """Run to the end; RunError when an FMU fails. Frees everything in any case."""
        base = self.package.base
        sizes = {n: sum(len(s.scalars) for _, s in c) for n, c in self._columns().items()}
        check_memory(sizes, n_steps, base)
        logs, n_logs = self._logs(n_steps)
        components = self._array(library.ComponentData, self.components)
        message = ctypes.create_string_buffer(1024)
        count, width, rows = len(self.components), len(self.played.ends), self.played.rows
        n_slots = len(self.slots) + width
        executor = c.executor_open(
            components, count, n_slots, base, logs, n_logs, timing, message, len(message)
        )
        if not executor:
            raise RunError(as_text(message.value))
        if width:
            c.executor_play(executor, rows.ctypes.data, len(rows), len(self.slots), width)
        try:
            self._advance(c, executor, n_steps, progress)
        finally:
            for k, instance in enumerate(self.package.instances):
                spent = c.executor_time_of(executor, k)
                self.times[instance.name] = FmuTime(
                    spent.seconds,
                    spent.worst,
                    spent.steps,
                    spent.warnings,
                    as_text(c.executor_warning_of(executor, k)),
                )
            c.executor_close(executor)

    def _advance(self, c: Any, executor: int, n_steps: int, progress: Progress | None) -> None:
        done, chunk, base = 0, 64, self.package.base
        while done < n_steps:
            begin = time.perf_counter()
            done = min(done + chunk, n_steps)
            if not c.executor_run(executor, done):
                raise RunError(as_text(c.executor_message(executor)))
            if progress:
                progress(done * base, n_steps * base)
            # aim at a tenth of a second: progress moves and Ctrl-C is heard
            spent = max(time.perf_counter() - begin, 1e-6)
            chunk = max(1, min(int(chunk * 0.1 / spent), 4 * chunk, 100_000))

    def groups(self) -> dict[str, Group]:
        """The logged rows as arrays by variable."""
        base, groups = self.package.base, {}
        for steps, columns in self._columns().items():
            rows, first = self.buffers[steps], 0
            signals, units, descriptions, elements = {}, {}, {}, {}
            for component, signal in columns:
                name, size = f"{component}.{signal.name}", len(signal.scalars)
                block = rows[:, first : first + size]
                signals[name] = block if signal.is_array else block[:, 0]
                units[name] = signal.unit
                descriptions[name] = signal.scalars[0].description
                if signal.elements not in (("",), indices(size)):
                    elements[name] = signal.elements
                first += size
            group = Group(steps, base, signals, units, descriptions, elements)
            groups[rate_name(steps, base)] = group
        return groups


def by_type(listed: Sequence[FmuVariable]) -> list[FmuVariable]:
    """In the order of the executor's variables; without Strings, of which it knows nothing."""
    return [v for types in TYPES for v in listed if v.type in types]


def _extract(package: Package, folder: Path) -> dict[str, Path]:
    """Binaries and resources of every FMU, once each; by source."""
    roots = {}
    for k, (source, data) in enumerate(package.fmus.items()):
        root = folder / str(k)
        model = next(i.fmu.model for i in package.instances if i.source == source)
        archive, binary = open_zip(data, source), binary_path(model)
        if binary not in archive.namelist():
            raise InterfaceError(
                f"{package.path}: {source} holds no {binary}: build it for this machine,"
                " for instance with `fmpy compile`"
            )
        for name in archive.namelist():
            if name == binary or name.startswith("resources/"):
                read_member(archive, name, f"{package.path}: {source}")  # damage gets a message
                archive.extract(name, root)
        (root / "resources").mkdir(parents=True, exist_ok=True)
        roots[source] = root
    return roots


def as_text(message: bytes) -> str:
    return message.decode("utf-8", errors="replace")
