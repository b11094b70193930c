"""Options whose values are a fixed list: the list is the one that is implemented."""

from __future__ import annotations

import subprocess
import sys

import typer
from typer.testing import CliRunner

from flexhex import arguments
from flexhex.diagnose.command import KINDS as BASE_KINDS
from flexhex.diagnosis.bases import BASES
from flexhex.experiments import EXPERIMENTS
from flexhex.export.command import TOOLS
from flexhex.export.wiring import WIRINGS
from flexhex.fmugen.platforms import PLATFORMS
from flexhex.output.interrupt import Interruptible
from flexhex.run.command import Part
from flexhex.run.paper import TABLE
from flexhex.study.command import KINDS
from flexhex.study.draws import VARIED


def test_lists_of_the_command_line_are_those_of_the_library() -> None:
    """They stand twice so that `flexhex --help` need not import the library."""
    assert [part.value for part in Part] == [TABLE, *EXPERIMENTS]
    assert tuple(VARIED) == KINDS
    assert tuple(PLATFORMS) == arguments.PLATFORMS
    assert set(BASE_KINDS) == set(BASES)
    assert set(TOOLS) == set(WIRINGS)


def test_list_is_completed_after_its_last_comma() -> None:
    values = ("noise", "payload", "drift")
    assert arguments.listed_values("no", values) == ["noise"]
    assert arguments.listed_values("noise,", values) == ["noise,payload", "noise,drift"]
    assert arguments.listed_values("noise,d", values) == ["noise,drift"]


def test_ctrl_c_is_one_line_and_exit_code_130() -> None:
    app = typer.Typer(cls=Interruptible)

    @app.command("wait")
    def wait() -> None:
        raise KeyboardInterrupt

    app.callback()(lambda: None)
    done = CliRunner().invoke(app, ["wait"])
    assert (done.exit_code, done.stderr, done.stdout) == (130, "flexhex: stopped\n", "")


def test_closed_pipe_is_silent_and_no_failed_check() -> None:
    """Exit code 1 would mean a failed check."""
    with subprocess.Popen(
        [sys.executable, "-m", "flexhex", "check", "--help"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        said = process.stderr.read()
    assert (process.returncode, said) == (141, b"")
