"""The player: its table equals quintics through the rows, at the instant that it shows."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from ctypes import byref
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import printLogMessage
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray
from scipy.interpolate import BPoly

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.player.table import Kind, Table
from flexhex.trajectory.variant import build_player
from results.plots import plot
from tests.blocks.test_alone import assert_same_picture
from tests.compare import assert_close
from tests.conftest import ROOT
from tests.test_documents import blocks

Array = NDArray[np.float64]
TS, START = 0.00025, 0.002
TIME = np.array([0.0, 0.0101, 0.01015, 0.0102, 0.03, 0.05])
"""Rows closer than a tick, and not on ticks."""
KEPT = fmi2CallbackFunctions()
"""Lives as long as the process."""


def table(kind: Kind) -> Table:
    """Random rows, the first and the last at rest."""
    n = 6 if kind == "joints" else 7
    rng = np.random.default_rng(3)
    rows = np.hstack([rng.normal(size=(len(TIME), n)) * 0.1 ** (2 - k) for k in range(3)])
    rows[[0, -1], n:] = 0.0
    return Table(kind, TIME, rows, np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0]))


@pytest.fixture(scope="module")
def player(machine: Machine, tmp_path_factory: pytest.TempPathFactory) -> dict[Kind, Path]:
    """Both kinds of players."""
    kinds: tuple[Kind, ...] = ("joints", "pose")
    by_name = {}
    for kind in kinds:
        folder = tmp_path_factory.mktemp(kind)
        build_player(table(kind), machine, folder)
        by_name[kind] = folder / "player.fmu"
    return by_name


def played(path: Path, stop: float, start: float = START) -> Array:
    """All outputs but payload and fault, as FMPy records them, with time and payload in front."""
    listed = fmpy.read_model_description(str(path)).modelVariables
    names = [v.name for v in listed if v.causality == "output"]
    assert names[-2:] == ["payload", "fault"]
    rows = simulate_fmu(
        str(path), stop_time=stop, step_size=TS, output_interval=TS, output=names,
        start_values={"t_start": start},
    )  # fmt: skip
    assert not rows["fault"].any()
    return np.column_stack([rows["time"], rows["payload"], *(rows[name] for name in names[:-2])])


@pytest.mark.parametrize("kind", ["joints", "pose"])
def test_player_shows_the_quintic_of_its_rows_at_the_instant(
    player: dict[Kind, Path], kind: Kind
) -> None:
    known = table(kind)
    n = known.rows.shape[1] // 3
    shown = played(player[kind], START + 0.06)
    t = np.clip(np.round(shown[:, 0] / TS) * TS - START, 0, TIME[-1])
    twin = BPoly.from_derivatives(TIME, known.rows.reshape(len(TIME), 3, n))
    for order in range(3):
        wanted = (twin.derivative(order) if order else twin)(t)
        part = shown[:, 2 + order * n : 2 + (order + 1) * n]
        # rows 50 us apart: differences of 0.1 over h^2, rounded
        assert_close(part, wanted, rtol=1e-10, what=f"derivative {order}")
    due = np.clip(np.searchsorted(TIME, t, side="right") - 1, 0, 5)
    assert np.array_equal(shown[:, 1], known.payload[due])
    assert np.array_equal(shown[0, 2 : 2 + n], known.rows[0, :n])


def test_player_rests_before_and_after(player: dict[Kind, Path]) -> None:
    shown, rows = played(player["joints"], 0.08, start=0.01), table("joints").rows
    before, after = shown[:, 0] < 0.01 - TS / 2, shown[:, 0] > 0.01 + TIME[-1] + TS / 2
    assert (shown[before, 2:] == rows[0]).all()
    assert_close(shown[after, 2:8], np.tile(rows[-1, :6], (after.sum(), 1)), atol=1e-15)
    # rounding of a polynomial of degree five, over the 20 ms of its last piece
    assert_close(shown[after, 8:14], np.zeros((after.sum(), 6)), atol=1e-12)


@pytest.fixture
def logger_of_fmpy() -> Iterator[None]:
    """FMPy's own logger afterwards. `simulate_fmu(logger=...)` hands its callback to a library that
    keeps it for the whole process: the next message of any FMU would call what is freed."""
    yield
    KEPT.logger = fmi2CallbackLoggerTYPE(printLogMessage)
    addLoggerProxy(byref(KEPT))


@pytest.mark.usefixtures("logger_of_fmpy")
def test_player_refuses_a_start_between_ticks(player: dict[Kind, Path]) -> None:
    messages: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate_fmu(
            str(player["joints"]),
            stop_time=0.01,
            start_values={"t_start": 0.0001},
            logger=lambda *words: messages.append(words[-1].decode()),
        )
    assert "t_start = 0.0001 s, must be a whole number of Ts = 0.00025 s" in "".join(messages)


@pytest.mark.parametrize("kind", ["joints", "pose"])
def test_player_passes_all_checks(player: dict[Kind, Path], kind: Kind) -> None:
    """What conformity tests of the other FMUs do: description, calls, states, ranges, sources."""
    words = [sys.executable, "-m", "flexhex", "check", str(player[kind])]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()[-2:]) == (0, "ok"), done.stdout + done.stderr


def test_player_is_the_same_byte_for_byte(
    player: dict[Kind, Path], machine: Machine, tmp_path: Path
) -> None:
    build_player(table("pose"), machine, tmp_path)
    assert (tmp_path / "player.fmu").read_bytes() == player["pose"].read_bytes()


def test_lines_of_the_readme_print_and_plot_what_they_say(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    text = (ROOT / "fmus" / "player" / "README.md").read_text(encoding="utf-8")
    (code,), (wanted,) = blocks(text, "python"), blocks(text, "text")
    (command,) = blocks(text, "sh")
    words = command.split()[1:]
    words[words.index("out/hexapod.ssp")] = str(hexapod_ssp)
    words += ["--out", str(tmp_path)]
    subprocess.run([sys.executable, "-m", "flexhex", *words], cwd=ROOT, check=True)
    here = code.replace("out/export", str(tmp_path))
    done = subprocess.run([sys.executable, "-c", here], capture_output=True, text=True, check=False)
    assert done.stdout == wanted, done.stderr[-2000:]
    kept = (ROOT / "fmus" / "player" / "plot.svg").read_text(encoding="utf-8")
    assert_same_picture(plot("player", tmp_path), kept)
    assert text.count("](plot.svg)") == 1
