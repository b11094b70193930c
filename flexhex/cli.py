"""`flexhex`: the command line. Exit codes: 0 ok, 1 check failed, 2 usage, 3 bad input, 4 build.

Each command is in `<command>/command.py` and imports what it needs when it is called.
"""

from __future__ import annotations

import os
import sys
from typing import Annotated, NoReturn

import typer

from flexhex import __version__
from flexhex.build.command import build_command
from flexhex.check.command import check_command
from flexhex.compare.command import compare_command
from flexhex.convert.command import convert_command
from flexhex.diagnose.command import diagnose_command
from flexhex.diagnose.options import Greedy
from flexhex.drive.command import drive_command
from flexhex.export.command import export_command
from flexhex.fmus.common.errors import FlexhexError
from flexhex.identify.command import identify_command
from flexhex.init.command import init_command
from flexhex.numeric.memory import keep
from flexhex.output.interrupt import Interruptible
from flexhex.output.usage import told
from flexhex.plot.command import plot_command
from flexhex.report.command import report_command
from flexhex.run.command import run_command
from flexhex.simulate.command import simulate_command
from flexhex.study.command import study_command
from flexhex.view.command import view_command

app = typer.Typer(
    cls=Interruptible,
    help="Adaptive feedforward of a flexure hexapod as FMI 2.0 FMUs; what the model of any machine"
    " lacks, found in its logs.",
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def show_version(wanted: bool) -> None:
    """Print the version and exit if `--version` is given."""
    if wanted:
        print(f"flexhex {__version__}")
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


app.command("run", short_help="Simulate the paper's cases: table and report.")(run_command)
app.command("build", short_help="Build FMUs and system descriptions.")(build_command)
app.command("simulate", short_help="Simulate a .ssp and save its signals.")(simulate_command)
app.command("identify", short_help="Estimate the parameters from logs.", cls=Greedy)(
    identify_command
)
app.command("diagnose", short_help="Find effects that the model lacks.", cls=Greedy)(
    diagnose_command
)
app.command(
    "init", short_help="Write a hexapod's machine file, an example of a base or an effect."
)(init_command)
app.command("view", short_help="Show a run: the machine in 3D beside its signals.", cls=Greedy)(
    view_command
)
app.command("plot", short_help="Plot signals of a run.")(plot_command)
app.command("convert", short_help="Write a run in another format.")(convert_command)
app.command("compare", short_help="Compare two runs.")(compare_command)
app.command("check", short_help="Check FMUs, .ssp and machine files.")(check_command)
app.command("study", short_help="Simulate many machines drawn at random.")(study_command)
app.command("export", short_help="Write files for other tools.")(export_command)
app.command("drive", short_help="Run the loop on emulated EtherCAT drives.")(drive_command)
app.command("report", short_help="Summarise a recording of the gateway.")(report_command)


_WRONG_KIND: dict[type[OSError], str] = {
    FileExistsError: "is a file, must be a folder",
    FileNotFoundError: "no such file",
    NotADirectoryError: "part of this path is a file, must be a folder",
}


def one_blas_thread() -> None:
    """One thread for NumPy's linear algebra, unless the user wants more.

    The matrices of fits and diagnoses are small: several threads take ten times the processor
    time, most of it waiting for one another. It counts only before NumPy is imported.
    """
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")


def main() -> None:
    """Entry point: a user's mistake is one message and an exit code, never a traceback."""
    one_blas_thread()
    keep()
    try:
        app()
    except FlexhexError as error:
        if os.environ.get("FLEXHEX_DEBUG"):
            raise
        _end(str(error), error.exit_code)
    except OSError as error:
        if os.environ.get("FLEXHEX_DEBUG"):
            raise
        why = _WRONG_KIND.get(type(error), str(error.strerror or error))
        _end(f"{error.filename or 'file'}: {why}", 3)


def _end(error: str, code: int) -> NoReturn:
    """Say what is wrong and leave."""
    print(f"flexhex: {error}", file=sys.stderr)
    told(error, code)
    sys.exit(code)


if __name__ == "__main__":
    main()
