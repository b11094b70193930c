"""Options whose values are a fixed list: the list is the one that is implemented."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
import typer
from typer.testing import CliRunner

from flexhex import arguments
from flexhex.base_options import KINDS as BASE_KINDS
from flexhex.cli import app
from flexhex.diagnosis.basemodels.bases import BASES
from flexhex.experiments import EXPERIMENTS
from flexhex.export.command import TOOLS
from flexhex.export.wiring import WIRINGS
from flexhex.fmugen.platforms import PLATFORMS
from flexhex.output.interrupt import Interruptible
from flexhex.run.command import Only
from flexhex.run.paper import TABLE
from flexhex.study.command import KINDS
from flexhex.study.draws import VARIED


def test_lists_of_the_command_line_are_those_of_the_library() -> None:
    """They stand twice so that `flexhex --help` need not import the library."""
    assert [part.value for part in Only] == [TABLE, *EXPERIMENTS]
    assert tuple(VARIED) == KINDS
    assert tuple(PLATFORMS) == arguments.PLATFORMS
    assert set(BASE_KINDS) == set(BASES)
    assert set(TOOLS) == set(WIRINGS)


def test_list_is_completed_after_its_last_comma() -> None:
    values = ("noise", "payload", "drift")
    assert arguments.listed_values("no", values) == ["noise"]
    assert arguments.listed_values("noise,", values) == ["noise,payload", "noise,drift"]
    assert arguments.listed_values("noise,d", values) == ["noise,drift"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("run --qick", "run: no such option: --qick"),
        ("run --only fig2", "run: invalid value for '--only': 'fig2' is not one of 'table', "),
        ("compare a.h5", "compare: missing argument 'SECOND'"),
        ("study -n 1.5", "study: invalid value for '--runs' / '-n': "),
        ("diagnose --held-out", "diagnose: option '--held-out' requires an argument"),
        ("frobnicate", "no such command 'frobnicate'"),
        ("--nope", "no such option: --nope"),
    ],
)
def test_wrong_option_is_two_plain_lines(words: str, message: str) -> None:
    done = CliRunner().invoke(app, words.split(), prog_name="flexhex")
    assert (done.exit_code, done.stdout) == (2, "")
    said, where = done.stderr.splitlines()
    assert said.startswith((f"flexhex {message}", f"flexhex: {message}"))
    command = f"{words.split()[0]} " if said.startswith("flexhex ") else ""
    assert where == f"`flexhex {command}--help` lists what there is"


def test_flexhex_alone_shows_its_help() -> None:
    done = CliRunner().invoke(app, [], prog_name="flexhex")
    assert "Usage: flexhex" in done.output
    assert "simulate" in done.output


def test_ctrl_c_is_one_line_and_exit_code_130() -> None:
    waiting = typer.Typer(cls=Interruptible)

    @waiting.command("wait")
    def wait() -> None:
        raise KeyboardInterrupt

    waiting.callback()(lambda: None)
    done = CliRunner().invoke(waiting, ["wait"])
    assert (done.exit_code, done.stderr, done.stdout) == (130, "flexhex: stopped\n", "")


def test_closed_pipe_is_silent_and_no_failed_check() -> None:
    """Exit code 1 would mean a failed check. Closed before the command starts: nobody waits."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "flexhex", "check", "--help"]
    process = subprocess.run(command, stdout=write, stderr=subprocess.PIPE)
    os.close(write)
    assert (process.returncode, process.stderr) == (141, b"")
