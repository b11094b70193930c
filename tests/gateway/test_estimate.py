"""What the estimator learned, from one run to the next: to the last bit, or refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexhex.ssp.read import read_ssp
from tests.gateway.bench import Bench, Ran, Rows
from tests.gateway.slave import Slave
from tests.gateway.test_faults import faults
from tests.gateway.test_lockstep import same
from tests.gateway.test_readback import SHORT

TS, PERIOD, T_START = 0.00025, 120, 0.3
"""Base step [s], base steps between two updates of K, time of the first update [s]."""
SECONDS = 1.0
INSIDE = ('own_thread = ["K"]', "own_thread = []")
OTHER_R2 = ('feedforward = "', 'parameters = { "K.R2" = 0.5 }\nfeedforward = "')

STD = '"p_std.actuator[1].o",\n          '


def run_again(bench: Bench, file: Path, *, seconds: float = SHORT, **more: object) -> Ran:
    """A run that resumes a file."""
    command = ("run", "--enable", "--lockstep", "--resume", file)
    again = Bench(bench.ssp, bench.folder, bench.kind)
    return again.run(command=command, seconds=seconds, record=bench.folder / "b.csv", **more)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def learned(hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Bench, Path]:
    """A run, and the file that it leaves."""
    bench = Bench(hexapod_ssp, tmp_path_factory.mktemp("learned"))
    ran = bench.run(seconds=SECONDS)
    assert ran.code == 0, ran.words
    file = Path(ran.one("estimate")["file"])
    assert file == bench.folder / "run-estimate.json"
    return bench, file


def entry(file: Path) -> dict[str, object]:
    """The only state in a file."""
    (state,) = json.loads(file.read_text())["states"]
    return dict(state)


class Estimator(Slave):
    """estimator.fmu, put into a saved state."""

    def __init__(self, fmu: Path, state: dict[str, object], folder: Path) -> None:
        super().__init__(fmu, folder, "K")
        restored = self.fmu.deSerializeFMUstate(bytes.fromhex(str(state["state"])))
        self.fmu.setFMUstate(restored)
        self.steps = int(str(state["steps"]))

    def step(self, inputs: dict[str, float]) -> None:
        """One update."""
        self.set(inputs)
        self.fmu.doStep(self.steps * TS, PERIOD * TS)
        self.steps += PERIOD


def test_resumed_estimator_goes_on_from_its_state_to_the_last_bit(
    learned: tuple[Bench, Path], fmu_dir: Path, tmp_path: Path
) -> None:
    """K alone, with the inputs of the second run, makes the second run's estimates."""
    bench, file = learned
    state = entry(file)
    saved = {str(name): float(value) for name, value in state["outputs"]}  # type: ignore[attr-defined]
    names = [name for name in saved if name.startswith(("p.", "p_std."))]
    wires = [w for w in read_ssp(bench.ssp).wires if w.target == "K"]
    sources = list(dict.fromkeys(f"{w.source}.{w.output}" for w in wires))
    signals = ", ".join(f'"{s}"' for s in [*(f"K.{name}" for name in names), *sources])
    ran = run_again(
        bench, file, seconds=SECONDS, changes=(("signals = []", f"signals = [{signals}]"),)
    )
    assert ran.code == 0, ran.words
    assert f"# resumed: {file}" in ran.recording.read_text()
    rows = flat(ran)
    running = rows["phase"] == 1
    ours = np.column_stack([rows[f"K.{name}"][running] for name in names])
    # nothing is learned before the filters have settled, at the start of this run as of the first
    first = round(T_START / TS)
    begin = np.array([saved[name] for name in names])
    assert same(ours[: first + PERIOD], np.tile(begin, (first + PERIOD, 1)))
    alone = Estimator(fmu_dir / "estimator.fmu", state, tmp_path)
    for n in range(first, len(ours) - PERIOD, PERIOD):
        alone.step({w.input: rows[f"{w.source}.{w.output}"][running][n] for w in wires})
        theirs = np.array([alone.get(names)])
        assert same(ours[n + PERIOD : n + PERIOD + 1], theirs), n
        assert not same(theirs, begin[None]), "it learns"
    # not from the beginning: the deviations are those of the first run, not of P0
    start = dict(state["parameters"])  # type: ignore[call-overload]
    largest = [
        np.sqrt(start[f"P0{k}"]) * start[f"scale{k}"]
        for k in (name[5:] for name in saved if name.startswith("p_std."))
    ]
    assert np.min(np.array([saved[n] for n in saved if n.startswith("p_std.")]) / largest) < 0.5


def flat(ran: Ran) -> dict[str, Rows]:
    """Columns by their whole names."""
    lines = [line for line in ran.recording.read_text().splitlines() if not line.startswith("#")]
    data = np.loadtxt(lines[2:], delimiter=",", ndmin=2)
    return dict(zip(lines[0].split(","), data.T, strict=True))


def refused(ran: Ran, code: int = 3) -> str:
    """The message of a run that was refused before a frame was sent."""
    assert ran.code == code, ran.words
    assert not ran.happened("state"), "not one frame was sent"
    return str(ran.one("refused")["message"])


def test_state_that_does_not_fit_is_refused_before_power(
    learned: tuple[Bench, Path], tmp_path: Path
) -> None:
    bench, file = learned
    message = refused(run_again(bench, file, changes=(OTHER_R2,)))
    assert "K: R2 = 0.5, but R2 = " in message
    assert "start without the saved state" in message
    assert "name it in own_thread" in refused(run_again(bench, file, changes=(INSIDE,)))
    message = refused(run_again(bench, file, changes=(("range = 5.0", "range = 0.00001"),)))
    assert "K.p." in message
    assert "(estimate.range)" in message
    assert "No such file" in refused(run_again(bench, tmp_path / "none.json"))


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('"guid": "{', '"guid": "{0', "the state is of the FMU {0"),
        ('"state": "', '"state": "00', "K: its state is not the one that was written (state_hash)"),
        (STD, f"{STD}1e999 #", "no estimate (number out of range"),
        (STD, f"{STD}NaN #", "no estimate (expected value"),
        (
            '"p.actuator[1].o",\n          -',
            '"p.actuator[1].o",\n          -1',
            "the file was changed",
        ),
    ],
    ids=["another FMU", "damaged", "infinite", "no number", "edited"],
)
def test_changed_file_is_refused_before_power(
    old: str, new: str, why: str, learned: tuple[Bench, Path], tmp_path: Path
) -> None:
    bench, file = learned
    text = file.read_text()
    assert text.count(old) == 1, old
    bad = tmp_path / "bad.json"
    bad.write_text(text.replace(old, new))
    changes = (("range = 5.0", "range = 100.0"),)
    assert why in refused(run_again(bench, bad, changes=changes))


def test_nothing_is_saved_without_a_good_end(hexapod_ssp: Path, tmp_path: Path) -> None:
    """A trip may have spoilt the estimate, and a dry run moves nothing."""
    bench = Bench(hexapod_ssp, tmp_path)
    tripped = bench.run(options=faults('kind = "drive_fault"'))
    assert tripped.one("trip")
    for ran in (tripped, bench.run(command=("run", "--dry-run", "--lockstep"), seconds=SHORT)):
        assert not [e for e in ran.events if e["event"] == "estimate"], ran.words
    assert not list(tmp_path.glob("*estimate*"))
