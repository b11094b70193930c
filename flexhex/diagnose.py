"""Command `diagnose`, registered by `flexhex.cli`: finds what the model lacks in measured runs."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from typer.core import TyperCommand

from fmus.common.errors import UsageError

if TYPE_CHECKING:
    from diagnosis.logs import Options as LogOptions
    from diagnosis.verdict import Diagnosis
    from flexhex.diagnose_words import Asked

GREEDY = ("--locked",)
"""Options that take all words up to the next option."""


class Greedy(TyperCommand):
    """A command whose `--locked a b c` means `--locked a --locked b --locked c`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Repeat a greedy option before each of its words."""
        return super().parse_args(ctx, repeated(args))


def repeated(args: list[str]) -> list[str]:
    """Words in which every greedy option stands before each of its values."""
    made: list[str] = []
    option, first = "", False
    for k, word in enumerate(args):
        if word == "--":
            return [*made, *args[k:]]
        if word.startswith("-") and len(word) > 1:
            option, first = (word, True) if word in GREEDY else ("", False)
            made.append(word)
        else:
            made += [word] if not option or first else [option, word]
            first = False
    return made


def diagnose_command(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="logs of one machine, or trajectories")
    ],
    locked: Annotated[
        list[Path] | None,
        typer.Option(metavar="RUN...", help="runs to be judged on alone, of other trajectories"),
    ] = None,
    machine: Annotated[
        Path | None, typer.Option("--machine", "-m", help="machine file (TOML)")
    ] = None,
    base: Annotated[
        str, typer.Option(help="hexapod, axis (each by itself) or schunk (six-axis arm)")
    ] = "hexapod",
    apply: Annotated[
        bool, typer.Option("--apply", help="add what is found, build the FMUs, without asking")
    ] = False,
    isolability: Annotated[
        bool, typer.Option("--isolability", help="which effects could these trajectories show?")
    ] = False,
    torque_constant: Annotated[
        str | None, typer.Option(metavar="N m/A", help="of logs in A: 3.0, or one for each axis")
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option(metavar="CHANNEL=UNIT", help="unit a log does not tell")
    ] = None,
    rename: Annotated[
        list[str] | None, typer.Option(metavar="NAME=CHANNEL", help="what a column is")
    ] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="folder for all that is written")] = Path(
        "out/diagnose"
    ),
    report: Annotated[Path | None, typer.Option(help="page, default OUT/diagnosis.html")] = None,
    json: Annotated[bool, typer.Option("--json", help="result as JSON on stdout")] = False,
) -> None:
    """Find what the model lacks: exit code 0 nothing or added, 1 a gap or cannot tell."""
    from diagnosis.options import BASES, Options
    from flexhex.cli import DEFAULT_MACHINE, found_machine

    if base not in BASES:
        raise UsageError(f"--base {base}: there are {', '.join(BASES)}")
    file = found_machine(machine or DEFAULT_MACHINE) if machine or base == "hexapod" else None
    logs = log_options(torque_constant, unit or [], rename or [])
    page = report or out / ("isolability.html" if isolability else "diagnosis.html")
    session = Session(page, json, apply)
    if isolability:
        session.isolate(runs, file, Options(base, out, logs))
        return
    both = {path.resolve() for path in runs} & {path.resolve() for path in locked or []}
    if both:
        raise UsageError(f"{min(both).name} is given as a run and as a locked one: choose")
    options = Options(base, out, logs, session.agree)
    found = session.diagnose(runs, locked or [], file, options)
    if found.verdict != "none" and found.machine is None:
        raise typer.Exit(1)


class Session:
    """One diagnosis with its user: bars on stderr, a question, results on stdout."""

    def __init__(self, page: Path, json: bool, apply: bool) -> None:
        self.page, self.json, self.apply = page, json, apply
        self.bars = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=Console(stderr=True),
        )
        self.asked: Asked = _asked("hexapod")
        self._tasks: dict[str, Any] = {}
        self._told = False

    def progress(self, text: str, done: int, total: int) -> None:
        """`done` of `total` steps of a stage; total 0: nobody knows how many."""
        if text not in self._tasks:
            self._tasks[text] = self.bars.add_task(text, total=None)
        self.bars.update(self._tasks[text], completed=done, total=total or None)

    def agree(self, found: Diagnosis) -> bool:
        """Whether what was found is to be added: as told by --apply, else by the user."""
        from flexhex.diagnose_view import best_of, print_diagnosis
        from flexhex.diagnose_words import APPLICABLE

        if found.verdict not in APPLICABLE:
            return False
        if self.apply or self.json or not interactive():
            return self.apply
        self.bars.stop()
        print_diagnosis(found, self.asked)
        self._told = True
        what = [best_of(effect) for effect in found.effects]
        what += [f"the new value of {change.parameter}" for change in found.changed]
        text = f"\nAdd {', '.join(what)} to a copy of the machine file and build it?"
        wanted = bool(typer.confirm(text, default=False, err=True))
        if wanted:
            self.bars.start()
        return wanted

    def diagnose(
        self, runs: list[Path], locked: list[Path], file: Path | None, options: Any
    ) -> Diagnosis:
        """Run the workflow, write the page, print the answer."""
        self.asked = _asked(options.base)
        with self.bars:
            found: Diagnosis = _stage("workflow").diagnose(
                runs, locked, file, options, self.progress
            )
        from flexhex.diagnose_page import write_diagnosis
        from flexhex.diagnose_view import diagnosis_json, print_applied, print_diagnosis, say

        written = write_diagnosis(found, self.asked, [*runs, *locked], self.page)
        if self.json:
            print(diagnosis_json(found, written))
        elif self._told:
            print_applied(found, written, self.asked)
        else:
            print_diagnosis(found, self.asked)
            say(Console(), f"report   {written}")
        return found

    def isolate(self, trajectories: list[Path], file: Path | None, options: Any) -> None:
        """Which effects the trajectories could show and tell apart."""
        with self.bars:
            found = _stage("isolability").isolability(trajectories, file, options, self.progress)
        from flexhex.diagnose_isolability import (
            isolability_json,
            print_isolability,
            write_isolability,
        )

        written = write_isolability(found, [str(path) for path in trajectories], self.page)
        if self.json:
            print(isolability_json(found, written))
        else:
            print_isolability(found, written)


def interactive() -> bool:
    """Whether somebody sits there who can answer."""
    return sys.stdin.isatty()


def log_options(constant: str | None, units: list[str], names: list[str]) -> LogOptions:
    """How to read logs; UsageError tells what is wrong with an option."""
    from diagnosis.logs import Options as LogOptions

    constants: float | tuple[float, ...] | None = None
    if constant is not None:
        try:
            constants = tuple(float(word) for word in constant.split(","))
        except ValueError:
            text = f"--torque-constant {constant}: write a number, or one for each axis: 3.0,3.1"
            raise UsageError(text) from None
        if not all(0 < value < float("inf") for value in constants):
            raise UsageError(f"--torque-constant {constant}: must be positive")
        constants = constants[0] if len(constants) == 1 else constants
    return LogOptions(constants, _pairs("--unit", units), _pairs("--rename", names))


def _pairs(option: str, words: list[str]) -> dict[str, str]:
    made = {}
    for word in words:
        name, _, value = word.rpartition("=")
        if not (name and value):
            raise UsageError(f"{option} {word}: write NAME=VALUE")
        made[name] = value
    return made


def _stage(name: str) -> Any:
    """A module of the diagnosis, imported when it is needed: CasADi and SciPy take seconds."""
    return importlib.import_module(f"diagnosis.{name}")


def _asked(base: str) -> Asked:
    from flexhex.diagnose_words import Asked

    return Asked((Path(sys.argv[0]).name, *sys.argv[1:]), base)
