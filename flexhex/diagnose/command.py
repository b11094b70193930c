"""Command `diagnose`, registered by `flexhex.cli`: finds what the model lacks in measured runs."""

from __future__ import annotations

import gc
import importlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexhex.arguments import AsJson
from flexhex.base_options import Base, Joints, OwnEffects, Tolerances, base_options, read_of
from flexhex.diagnose.options import interactive, once_each, refuse_inputs, writable
from flexhex.fmus.common.errors import UsageError
from flexhex.log_options import Motor, Rename, TorqueConstant, Unit, log_options

if TYPE_CHECKING:
    from flexhex.diagnosis.logs import Options as LogOptions
    from flexhex.diagnosis.prepare import Options
    from flexhex.diagnosis.result.verdict import Diagnosis


DATA = "diagnosis.json"
"""All that was found, in the output folder."""


def diagnose_command(
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN...", help="logs of one machine; with --isolability trajectories"
        ),
    ],
    held_out: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="RUN...",
            help="held-out runs of other trajectories: used for validation only; takes all words up"
            " to the next option",
        ),
    ] = None,
    locked: Annotated[
        list[Path] | None, typer.Option(metavar="RUN...", hidden=True, help="as --held-out")
    ] = None,
    machine: Annotated[
        Path | None, typer.Option("--machine", "-m", help="machine file (TOML)")
    ] = None,
    base: Base = "hexapod",
    joints: Joints = "",
    tolerance: Tolerances = None,
    effect: OwnEffects = None,
    apply: Annotated[
        bool,
        typer.Option(
            "--apply",
            help="add the effects to a copy of the machine file and build the FMUs, without asking",
        ),
    ] = False,
    isolability: Annotated[
        bool,
        typer.Option(
            "--isolability", help="which effects these trajectories could reveal and tell apart"
        ),
    ] = False,
    torque_constant: TorqueConstant = None,
    motor: Motor = None,
    unit: Unit = None,
    rename: Rename = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="output folder")] = Path("out/diagnose"),
    report: Annotated[
        Path | None, typer.Option(help="path of the report page; default: OUT/diagnosis.html")
    ] = None,
    json: AsJson = False,
) -> None:
    """Find effects that the model lacks. Exit code 0: none, or added to a machine file; 1: effects
    or an unexplained residual remain, or the runs do not decide."""
    logs = log_options(torque_constant, unit or [], rename or [], motor)
    options, file = base_options(base, machine, joints, tolerance, logs, effect)
    if apply and base != "hexapod":
        raise UsageError(f"--apply: --base {base} has no machine file to add anything to")
    validation = [*(held_out or []), *(locked or [])]
    if apply and effect:
        from flexhex.diagnosis.hypotheses.own_effect import own_effects

        for own in own_effects(effect).values():
            own.refuse_unbuilt()
    if isolability and (validation or apply or effect):
        which = "--held-out" if validation else "--apply" if apply else "--effect"
        raise UsageError(f"{which}: --isolability looks at planned motions, before any run")
    once_each(runs, validation)
    page = report or out / ("isolability.html" if isolability else "diagnosis.html")
    made = {out / DATA: "--out", page: "--report" if report else "--out"}
    if apply:
        made[out / "machine.toml"] = "--apply"
    refuse_inputs(made, [*runs, *validation, *read_of(options, file)])
    writable("--report" if report else "--out", page)
    writable("--out", out / page.name)
    session = Session(base, file, out, page, json, apply)
    if isolability:
        session.isolate(runs, options)
        return
    diagnosis = session.diagnose(runs, validation, options)
    if diagnosis.verdict != "none" and diagnosis.machine is None:
        raise typer.Exit(1)


class Session:
    """One diagnosis with its user: bars on stderr, a question, results on stdout."""

    def __init__(
        self, base: str, file: Path | None, out: Path, page: Path, json: bool, apply: bool
    ) -> None:
        from flexhex.diagnose.next import Invocation
        from flexhex.output.live import live

        self.base, self.file, self.out, self.page = base, file, out, page
        self.json, self.apply = json, apply
        self.invocation = Invocation(("flexhex", *sys.argv[1:]), base, str(out / DATA))
        self.progress = live()
        self._printed = False

    def diagnose(self, runs: list[Path], held_out: list[Path], options: Options) -> Diagnosis:
        """Run the workflow, add what is wanted, write the page, print the answer."""
        from rich.console import Console

        from flexhex.diagnosis.workflow import diagnose

        # what was loaded stays: each search for what has no owner need not look at it again
        gc.freeze()
        with self.progress:
            diagnosis = diagnose(
                *(runs, held_out, self.file, options, self.progress.steps), self.progress.note
            )
            diagnosis = self.planned(diagnosis, [*runs, *held_out], options.log)
            if self.file is not None and self.agree(diagnosis):
                diagnosis = self.added(diagnosis, self.file, runs, held_out, options.log)
        gc.unfreeze()
        from flexhex.diagnose.page import write_diagnosis
        from flexhex.diagnose.view import diagnosis_json, print_applied, print_diagnosis
        from flexhex.output.parts import say

        written = write_diagnosis(diagnosis, self.invocation, [*runs, *held_out], self.page)
        data = diagnosis_json(diagnosis, written)
        (self.out / DATA).write_text(data + "\n", encoding="utf-8")
        if self.json:
            print(data)
        elif self._printed:
            print_applied(diagnosis, written, self.invocation)
        else:
            print_diagnosis(diagnosis, self.invocation)
            say(Console(), f"report   {written}")
        return diagnosis

    def planned(self, diagnosis: Diagnosis, runs: list[Path], logs: LogOptions) -> Diagnosis:
        """With a trajectory file for each effect that has rivals."""
        if not any(effect.rivals for effect in diagnosis.effects):
            return diagnosis
        from flexhex.diagnosis.logs import read_log
        from flexhex.diagnosis.planning.experiment import Limits, with_experiments
        from flexhex.fmus.common.machine_file import load_machine

        self.progress.steps("writing the next experiment", 0, 0)
        if self.base == "hexapod" and self.file is not None:
            machine = load_machine(self.file)
            limits, ts = Limits.of_machine(machine), machine.timing.base
        else:
            read = [read_log(path, logs) for path in runs]
            limits, ts = Limits.of_logs(read), read[0].ts
        return with_experiments(diagnosis, limits, self.out, ts)

    def agree(self, diagnosis: Diagnosis) -> bool:
        """Whether what was found is to be added: as --apply says, else the user."""
        from flexhex.diagnose.next import applicable, best_of
        from flexhex.diagnose.numbers import listed
        from flexhex.diagnose.view import print_diagnosis

        if not applicable(diagnosis) or self.base != "hexapod":
            return False
        if self.apply or self.json or not interactive():
            return self.apply
        what = [best_of(effect) for effect in diagnosis.effects]
        lasting = [change for change in diagnosis.changed if not change.runs]
        what += [f"the new value of {change.parameter}" for change in lasting]
        text = f"\nAdd {listed(what)} to a copy of the machine file and build it?"
        with self.progress.paused():
            print_diagnosis(diagnosis, self.invocation)
            self._printed = True
            return bool(typer.confirm(text, default=False, err=True))

    def added(
        self,
        diagnosis: Diagnosis,
        file: Path,
        runs: list[Path],
        held_out: list[Path],
        logs: LogOptions,
    ) -> Diagnosis:
        """With what was found in a machine file of its own, built, replayed and run."""
        from flexhex.diagnose.apply import add

        def say(text: str) -> None:
            self.progress.steps(text, 0, 0)

        return add(diagnosis, file, self.out, runs, held_out, logs, say)

    def isolate(self, trajectories: list[Path], options: Options) -> None:
        """Which effects the trajectories could show and tell apart."""
        from flexhex.diagnose.isolability import (
            isolability_json,
            print_isolability,
            write_isolability,
        )

        with self.progress:
            module = importlib.import_module("flexhex.diagnosis.planning.isolability")
            isolability = module.isolability(trajectories, self.file, options, self.progress.steps)
        written = write_isolability(isolability, [str(path) for path in trajectories], self.page)
        if self.json:
            print(isolability_json(isolability, written))
        else:
            print_isolability(isolability, written)
