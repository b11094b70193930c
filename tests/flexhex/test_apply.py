"""From logs to a better model in one command: `flexhex diagnose ... --apply`, end to end."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.diagnosis.machine_files.extend import extended_file
from flexhex.experiments.missing import write_log
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import extra_cases
from flexhex.ssp.executor import run
from tests.conftest import MACHINE_FILE, OUT, one_at_a_time
from tests.flexhex.test_rebuild import AXIS, K_3, diagnosis, stiffness

pytestmark = pytest.mark.slow
SECONDS = 10.0
NOISE = {"theta": 2e-6, "tau_meas": 2e-3}
"""Standard deviations [rad, N m] of what is added to every pass."""


@pytest.fixture(scope="module")
def folder() -> Path:
    built = OUT / "apply"
    built.mkdir(parents=True, exist_ok=True)
    return built


@pytest.fixture(scope="module")
def bare(folder: Path) -> Path:
    """The default machine's file where no truth file lies beside it."""
    path = folder / "bare.toml"
    path.write_text(MACHINE_FILE.read_text(encoding="utf-8"), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def logs(folder: Path, bare: Path) -> dict[str, list[Path]]:
    """Runs of a machine with cubic stiffness on one axis: two trajectories and a held-out one."""
    file = extended_file(bare, diagnosis(stiffness(K_3)), folder / "stiff.toml")
    with one_at_a_time(OUT):
        builder = Builder(file, folder / "stiff")
        builder.systems()
    case = extra_cases(builder.machine, base_parameters(builder.machine), SECONDS)[1]
    random, paths = np.random.default_rng(5), dict[str, list[Path]]()
    for seed, trajectory in enumerate("abz", 31):
        result = run(
            builder.case(case),
            case.duration,
            signals=("plant.theta", "plant.tau_meas", "feedback.tau", "reference.r"),
            parameters={"reference.seed": float(seed)},
        )
        for number in (1, 2):
            path = folder / f"{trajectory}{number}.h5"
            write_log(result, path, trajectory, number)
            spoil(path, random)
            paths.setdefault(trajectory, []).append(path)
    return paths


def spoil(path: Path, random: np.random.Generator) -> None:
    """Noise of the sensors, another in every pass."""
    with h5py.File(path, "r+") as file:
        for name, deviation in NOISE.items():
            file[name][...] += deviation * random.standard_normal(file[name].shape)


@pytest.fixture(scope="module")
def answer(logs: dict[str, list[Path]], bare: Path, folder: Path) -> dict[str, Any]:
    """What the command prints with --json."""
    fitted = [str(path) for trajectory in "ab" for path in logs[trajectory]]
    words = ["diagnose", *fitted, "--held-out", *map(str, logs["z"]), "--machine", str(bare)]
    done = CliRunner().invoke(app, [*words, "--apply", "--out", str(folder / "out"), "--json"])
    assert done.exit_code == 0, done.output
    data: dict[str, Any] = json.loads(done.stdout)
    return data


def test_apply_names_what_the_machine_has(answer: dict[str, Any]) -> None:
    (effect,) = answer["effects"]
    assert (effect["id"], effect["axes"]) == ("cubic_stiffness", [AXIS])
    low, high = effect["parameters"]["k_3"]["ci95"]
    assert low < K_3 < high
    # an interval that holds anything would hold the truth too
    assert high - low < 0.2 * K_3


def test_apply_removes_the_residual_of_held_out_runs(answer: dict[str, Any]) -> None:
    residual = answer["residual"]
    assert residual["before"] - residual["non_repeatable"] > 10 * abs(
        residual["after"] - residual["non_repeatable"]
    )


def test_apply_leaves_the_machine_file_alone_and_extends_a_copy(
    answer: dict[str, Any], bare: Path
) -> None:
    assert not load_machine(bare).effects
    (use,) = load_machine(Path(answer["machine"])).effects
    assert (use.id, use.axes) == ("cubic_stiffness", (AXIS,))


def test_apply_builds_fmus_that_track_better(answer: dict[str, Any], folder: Path) -> None:
    assert (folder / "out" / "hexapod.ssp").exists()
    loop = answer["shown"]["closed_loop"]["model"]
    assert loop["after"]["e"] < 3.0 < loop["before"]["e"] / 2
