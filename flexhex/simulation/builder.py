"""From a machine file to FMUs and system descriptions under `out/`.

out/fmus/*.fmu                  nominal FMUs
out/hexapod.ssp                 the adaptive loop around the model (plant.fmu)
out/machine/hexapod.ssp         the adaptive loop around machine.fmu
out/cases/<case>/hexapod.ssp    variants of it, each with its own start values
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

from flexhex.fmugen.blocks import Source, Starts, block_interface, blocks, with_starts
from flexhex.fmus.common.interface import Interface
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, real_file, truth_file
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.simulation.cases import Case, check_settle, table_cases
from flexhex.simulation.machine_check import named, refuse_units
from flexhex.ssp.delays import alignment, reference_delay
from flexhex.ssp.hexapod import INSTANCES, hexapod
from flexhex.ssp.system import System
from flexhex.ssp.write import write_ssp

Say = Callable[[str], None]


@dataclass(frozen=True)
class Builder:
    """Builds for one machine file into `out`; `say` is called with what is being built."""

    machine_file: Path
    out: Path
    say: Say = lambda text: None
    platforms: tuple[str, ...] = ()
    """For which computers, as in `flexhex.fmugen.platforms`; default: this one."""

    @cached_property
    def machine(self) -> Machine:
        """The machine, read and checked once."""
        return load_machine(self.machine_file)

    def check(self) -> None:
        """Make all but the C code: MachineError names file and field of what an FMU refuses."""
        path, truth = self.machine_file, self.truth
        refuse_units(path, self.machine)
        makers = {
            block: partial(block_interface, block, self.machine) for block in blocks(self.machine)
        }
        for block, make in makers.items():
            named(path, make, block)
        named(path, partial(check_settle, self.machine))
        named(path, lambda: self.schedule, "feedback")
        for block, make in makers.items():
            named(path, partial(make, starts=self._starts_of(block)), block)
        if truth.exists():
            named(truth, self._machine.interface, "machine")

    @cached_property
    def truth(self) -> Path:
        """Where the file is that says how the machine differs from its model."""
        return truth_file(self.machine_file)

    @cached_property
    def real(self) -> Machine:
        """What machine.fmu is built from: the machine without what a diagnosis added."""
        return load_machine(real_file(self.machine_file))

    @cached_property
    def schedule(self) -> dict[str, dict[str, float]]:
        """Delays that follow from the schedule, by instance."""
        system = self._system({})
        return {
            "feedback": {"reference_delay": reference_delay(system, self.machine.drive)},
            "W": {"alignment": float(alignment(system))},
        }

    def fmus(self) -> list[Path]:
        """Nominal FMUs into `out/fmus`, and machine.fmu when a truth file exists."""
        self.check()
        folder, truth = self.out / "fmus", self.truth
        # the largest first; compilers run side by side
        largest_first = sorted(blocks(self.machine), key=("plant", "estimator").count, reverse=True)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            jobs = [
                pool.submit(self._block, block, folder, self._starts_of(block))
                for block in largest_first
            ]
            if truth.exists():
                jobs.insert(0, pool.submit(self._built, self._machine, folder, {}))
            return [job.result() for job in jobs]

    def systems(self) -> list[Path]:
        """FMUs, `out/hexapod.ssp` and, with a truth file, `out/machine/hexapod.ssp`."""
        self.fmus()
        p = base_parameters(self.machine)
        adaptive = table_cases(self.machine, p, self.machine.reference.duration)[-1]
        written = [self._write(self._around_model(adaptive), self.out / "hexapod.ssp")]
        if self.has_truth:
            written.append(self._write(adaptive, self.out / "machine" / "hexapod.ssp"))
        return written

    @cached_property
    def has_truth(self) -> bool:
        """Whether a truth file says how the machine differs from its model."""
        return self.truth.exists()

    def simulated(self, case: Case) -> Case:
        """The case as it is simulated: around the model where there is no truth file."""
        return case if self.has_truth or case.plant == "plant" else self._around_model(case)

    def case(self, case: Case, plant: Builder | None = None) -> Path:
        """`out/cases/<case>/hexapod.ssp`; plant: whose plant the controllers of this one drive."""
        path = self.out / "cases" / case.name / "hexapod.ssp"
        return self._write((plant or self).simulated(case), path, plant)

    @staticmethod
    def _around_model(case: Case) -> Case:
        """The case with plant.fmu in the place of machine.fmu."""
        starts = {name: values for name, values in case.starts.items() if name != "plant"}
        return Case(case.name, case.title, "plant", case.duration, starts)

    def _write(self, case: Case, path: Path, plant: Builder | None = None) -> Path:
        folder = path.parent / "fmus" if path.parent != self.out else self.out / "variants"
        interfaces: dict[str, Interface] = {}
        for instance, block in INSTANCES.items():
            name = case.plant if instance == "plant" else block
            starts = {**self.schedule.get(instance, {}), **case.starts.get(instance, {})}
            owner = plant if plant and instance == "plant" else self
            interfaces[instance] = owner.interface_of(block, name, starts)
            owner.place(block, name, starts, folder)
        system = hexapod(
            interfaces, base=self.machine.timing.base, sources={"plant": f"{case.plant}.fmu"}
        )
        return write_ssp(system, folder, path, stop=case.duration)

    def place(self, block: str, name: str, starts: Starts, folder: Path) -> None:
        """Build a variant into `folder`, or copy the FMU that needs none."""
        if starts and name == "machine":
            self._built(self._machine, folder, starts)
            return
        if starts:
            self._block(block, folder, starts)
            return
        source = self.out / "fmus" / f"{name}.fmu"
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, folder / source.name)

    def _block(self, block: str, folder: Path, starts: Starts) -> Path:
        self.say(block)
        return self._built(Source(block, self.machine), folder, starts)

    def _built(self, source: Source, folder: Path, starts: Starts) -> Path:
        return source.build_kept(folder, starts, self.out / "cache", self.platforms)

    @property
    def _machine(self) -> Source:
        return Source("plant", self.real, self.truth)

    def _starts_of(self, block: str) -> Starts:
        instances: Iterable[str] = (i for i, r in INSTANCES.items() if r == block)
        return next((self.schedule[i] for i in instances if i in self.schedule), {})

    def interface_of(self, block: str, name: str, starts: Starts) -> Interface:
        """Interface of a variant; machine.fmu shows nothing beyond the plant's own."""
        if name == "machine":
            return block_interface(block, self.real)
        return with_starts(block_interface(block, self.machine), starts)

    def _system(self, starts: Mapping[str, Starts]) -> System:
        interfaces = {
            block: block_interface(block, self.machine) for block in set(INSTANCES.values())
        }
        return hexapod(interfaces, base=self.machine.timing.base)
