"""`flexhex`: the command line. Exit codes: 0 ok, 1 check failed, 2 usage, 3 bad input, 4 build."""

from __future__ import annotations

import os
import sys
from importlib import metadata
from pathlib import Path
from typing import Annotated

import typer

from flexhex.commands import compare_command, study_command
from flexhex.diagnose.command import diagnose_command
from flexhex.diagnose.options import Greedy
from flexhex.drive.command import drive_command, report_command
from flexhex.export.command import export_command
from flexhex.log_options import Rename, TorqueConstant, Unit, log_options
from fmus.common.errors import FlexhexError

app = typer.Typer(
    help="Adaptive feedforward control of a flexure hexapod as FMI 2.0 co-simulation FMUs.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
)
SHIPPED = Path(__file__).resolve().parent.parent / "machines"
DEFAULT_MACHINE = Path("machines/tflex.toml")
"""Looked for here first, then among the machines that came with flexhex."""
MachineFile = Annotated[
    Path, typer.Option("--machine", "-m", help="machine file (TOML)", show_default=True)
]
OutFolder = Annotated[Path, typer.Option("--out", "-o", help="folder for everything generated")]
AsJson = Annotated[bool, typer.Option("--json", help="result as JSON on stdout")]


def show_version(wanted: bool) -> None:
    """Print the version and end, when asked."""
    if wanted:
        try:
            print(f"flexhex {metadata.version('flexhex')}")
        except metadata.PackageNotFoundError:
            print("flexhex, not installed")
        raise typer.Exit


@app.callback()
def options(
    debug: Annotated[bool, typer.Option("--debug", help="show tracebacks")] = False,
    version: Annotated[
        bool,
        typer.Option("--version", help="show the version", callback=show_version, is_eager=True),
    ] = False,
) -> None:
    """Options of all commands."""
    if debug:
        os.environ["FLEXHEX_DEBUG"] = "1"


@app.command()
def run(
    machine: MachineFile = DEFAULT_MACHINE,
    out: OutFolder = Path("out"),
    quick: Annotated[bool, typer.Option("--quick", help="short trajectory")] = False,
    only: Annotated[
        str | None,
        typer.Option(help="table, repeatability, hysteresis, payload, parameters or missing alone"),
    ] = None,
    json: AsJson = False,
) -> None:
    """Build, fit, simulate the paper's cases, print the table, write the report."""
    from flexhex.build import Builder
    from flexhex.console import LiveProgress, print_study, study_json
    from flexhex.report import write_report
    from flexhex.run import study

    with LiveProgress() as progress:
        builder = Builder(found_machine(machine), out, progress.building)
        found = study(builder, command(), quick, progress, only)
        progress.stage("writing the report")
        report = write_report(found, out / "report.html")
    if json:
        print(study_json(found, report))
    else:
        print_study(found, report)


@app.command()
def build(
    machine: MachineFile = DEFAULT_MACHINE,
    out: OutFolder = Path("out"),
    platform: Annotated[
        str | None,
        typer.Option(help="of linux64, win64, aarch64-linux, darwin64; default: this computer"),
    ] = None,
) -> None:
    """Build the FMUs and system descriptions of a machine."""
    from fmugen.platforms import wanted

    from flexhex.build import Builder
    from flexhex.console import LiveProgress

    platforms = wanted(platform) if platform is not None else ()

    with LiveProgress() as progress:
        progress.stage("building the FMUs")
        builder = Builder(found_machine(machine), out, progress.building, platforms)
        written = builder.systems()
    for path in written:
        print(path)


@app.command()
def simulate(
    description: Annotated[Path, typer.Argument(help="system description (.ssp)")],
    duration: Annotated[float, typer.Option("--duration", "-d", help="simulated time [s]")] = 10.0,
    result: Annotated[Path, typer.Option("--result", "-r", help="HDF5 file")] = Path("result.h5"),
    also: Annotated[list[str] | None, typer.Option(help="further signals, e.g. N_F.x")] = None,
) -> None:
    """Run a .ssp with the multi-rate executor and save its signals."""
    from flexhex.console import LiveProgress, print_speed
    from ssp.executor import run as execute
    from ssp.results import provenance, save
    from ssp.signals import DEFAULT

    with LiveProgress() as progress:
        advance = progress.line(description.name, duration)
        found = execute(description, duration, signals=[DEFAULT, *(also or [])], progress=advance)
    save(found, result, provenance(command=command()))
    print_speed(found)
    print(result)


@app.command()
def identify(
    logs: Annotated[list[Path], typer.Argument(help="logs of one machine (CSV, HDF5)")],
    machine: MachineFile = DEFAULT_MACHINE,
    settle: Annotated[
        float, typer.Option(help="left out at the start of each log [s]", min=0.0, max=1e6)
    ] = 2.0,
    torque_constant: TorqueConstant = None,
    unit: Unit = None,
    rename: Rename = None,
    json: AsJson = False,
) -> None:
    """Fit the 162 parameters to logs by least squares."""
    from diagnosis.identify import fit
    from diagnosis.logs import read_log
    from flexhex.fit_view import fit_json, print_fit
    from fmus.common.machine_file import load_machine

    given = log_options(torque_constant, unit or [], rename or [])
    described = load_machine(found_machine(machine))
    found = fit(described, [read_log(path, given) for path in logs], settle)
    if json:
        print(fit_json(described, found))
    else:
        print_fit(described, found)


@app.command()
def check(
    files: Annotated[list[Path], typer.Argument(help="FMUs, system descriptions, machine files")],
    results: Annotated[
        bool, typer.Option("--results", help="run FMUs against the results that they carry")
    ] = False,
) -> None:
    """Check FMUs (FMI rules, binary), .ssp (wiring, units, sample times) and machine files."""
    from flexhex.check.command import check_file
    from flexhex.console import print_findings

    if results:
        check_command_results(files)
        return
    findings = {path: check_file(path) for path in files}
    print_findings(findings)
    if any(findings.values()):
        raise typer.Exit(1)


def check_command_results(files: list[Path]) -> None:
    """Print the worst deviation of every output of FMUs; exit code 1 beyond tolerance."""
    from flexhex.check.results import check_results, print_deviations

    found = {path: check_results(path) for path in files}
    print_deviations(found)
    if not all(d.good for deviations in found.values() for d in deviations):
        raise typer.Exit(1)


def found_machine(path: Path) -> Path:
    """The machine file, or the shipped one of that name when the default is not here."""
    if path == DEFAULT_MACHINE and not path.exists():
        return SHIPPED / path.name
    return path


app.command("compare")(compare_command)
app.command("study")(study_command)
app.command("export")(export_command)
app.command("drive")(drive_command)
app.command("report")(report_command)
app.command("diagnose", cls=Greedy)(diagnose_command)


def command() -> str:
    """The command line as it was typed, without this machine's folders."""
    return " ".join([Path(sys.argv[0]).name, *sys.argv[1:]])


_IN_THE_WAY: dict[type[OSError], str] = {
    FileExistsError: "is a file, a folder is wanted",
    NotADirectoryError: "a part of this path is a file, a folder is wanted",
}


def main() -> None:
    """Entry point: a user's mistake is one message and an exit code, never a traceback."""
    try:
        app()
    except FlexhexError as error:
        if os.environ.get("FLEXHEX_DEBUG"):
            raise
        print(f"flexhex: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except OSError as error:
        if os.environ.get("FLEXHEX_DEBUG"):
            raise
        why = _IN_THE_WAY.get(type(error), str(error.strerror or error))
        print(f"flexhex: {error.filename or 'file'}: {why}", file=sys.stderr)
        sys.exit(3)


if __name__ == "__main__":
    main()
