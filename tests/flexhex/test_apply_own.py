"""An effect of the user's own from the logs into the FMUs: `flexhex diagnose --effect --apply`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.diagnosis.machine_files.extend import extend
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Named
from flexhex.experiments.missing import write_log
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine_file import load_machine, read_toml
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.fmus.estimator.interface import normalisation
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import Case, extra_cases
from flexhex.ssp.executor import run
from tests.conftest import MACHINE_FILE, OUT, one_at_a_time
from tests.flexhex.test_rebuild import diagnosis

SECONDS = 10.0
NOISE = {"theta": 2e-6, "tau_meas": 2e-3}
"""Standard deviations [rad, N m] of what is added to every pass."""
AXIS, TRUTH = 2, {"B": 0.12, "theta_m": 0.06, "w": 0.04}
UNITS = {"B": "N m", "theta_m": "rad", "w": "rad"}
DETENT = '''import numpy as np


class MagneticDetent:
    """Magnets that pull an axis to one angle."""

    gains = (("B", "N m", "positive"),)
    shapes = (("theta_m", "rad", (-0.1, 0.0, 0.1)), ("w", "rad", (0.02, 0.05, 0.1)))

    def columns(self, axis, theta_m, w):
        x = (axis.theta - theta_m) / w
        return x * np.exp(0.5 - x**2 / 2)
'''
NUMBERS = DETENT.replace("x * np.exp(0.5 - x**2 / 2)", "np.where(np.abs(x) < 2, x, 0.0)")


@pytest.fixture(scope="module")
def folder() -> Path:
    """With the default machine's file, where no truth file lies beside it, and the effect."""
    built = OUT / "apply-own"
    built.mkdir(parents=True, exist_ok=True)
    (built / "bare.toml").write_text(MACHINE_FILE.read_text(encoding="utf-8"), encoding="utf-8")
    (built / "detent.py").write_text(DETENT, encoding="utf-8")
    (built / "numbers.py").write_text(NUMBERS, encoding="utf-8")
    return built


def named(folder: Path, **other: float) -> Named:
    """What a diagnosis says of the effect."""
    values = TRUTH | other
    parts = ((AXIS, {k: Estimate(v, (v - 0.01, v + 0.01), UNITS[k]) for k, v in values.items()}),)
    origin = f"{(folder / 'detent.py').as_posix()}:MagneticDetent"
    return Named("magnetic_detent", "magnetic detent", (AXIS,), {}, parts, origin=origin)


def test_extended_file_names_the_file_of_the_effect_as_seen_from_there(folder: Path) -> None:
    bare, below = folder / "bare.toml", folder / "below" / "machine.toml"
    extended = extend(bare, diagnosis(named(folder)), below)
    assert read_toml(below)["effects"][0]["id"] == "../detent.py:MagneticDetent"
    (use,) = load_machine(below).effects
    assert (use.id, use.axes, use.gains, use.shape["w"]) == (
        "magnetic_detent",
        (2,),
        ((0.12,),),
        0.04,
    )
    # found again, it grows
    again = extend(extended.path, diagnosis(named(folder, B=0.03)), folder / "again.toml")
    (use,) = load_machine(again.path).effects
    assert use.gains == ((0.15,),)


def test_effect_that_the_plant_cannot_follow_is_left_out(folder: Path) -> None:
    extended = extend(
        folder / "bare.toml", diagnosis(named(folder, B=200.0)), folder / "steep.toml"
    )
    (text,) = extended.left_out
    assert text.startswith("magnetic_detent on axis 2: magnetic_detent changes by")


def test_effect_for_numbers_alone_is_refused_before_the_search(folder: Path) -> None:
    words = ["diagnose", "none.csv", "--machine", str(folder / "bare.toml"), "--out", str(folder)]
    own = ["--effect", f"{folder / 'numbers.py'}:MagneticDetent"]
    done = CliRunner().invoke(app, [*words, *own, "--apply"])
    assert isinstance(done.exception, MachineError)
    assert re.search(r"can be found, but not built: .*\(line 12\)", str(done.exception))


@pytest.fixture(scope="module")
def real(folder: Path) -> Builder:
    """The machine with the effect."""
    file = extend(folder / "bare.toml", diagnosis(named(folder)), folder / "real.toml").path
    with one_at_a_time(OUT):
        builder = Builder(file, folder / "real")
        builder.systems()
    return builder


def error(real: Builder, gain: float) -> float:
    """RMS of the tracking error [rad] of its loop with this gain in p, nothing adapting."""
    p = base_parameters(real.machine)
    assert p[162:].tolist() == [TRUTH["B"]]
    p[162] = gain
    starts = {
        "reference": {"seed": 1.0, "t_start": 1.0, "duration": 2.0},
        "K": {"p0": p, "scale": normalisation(real.machine, p), "adapt": 0.0},
    }
    path = real.case(Case("fixed", "fixed", "plant", 3.0, starts))
    e = run(path, 3.0, signals=["feedback.e"])["feedback.e"]
    return float(np.sqrt((e[round(1.1 / real.machine.timing.base) :] ** 2).mean()))


def test_plant_and_feedforward_of_the_file_have_the_effect(real: Builder) -> None:
    """With its gain in p the loop tracks as one with an exact model does, below 3 urad."""
    assert error(real, TRUTH["B"]) < 3e-6 < error(real, 0.0) / 4


@pytest.fixture(scope="module")
def logs(folder: Path, real: Builder) -> dict[str, list[Path]]:
    """Runs of that machine: two trajectories and a held-out one."""
    case = extra_cases(real.machine, base_parameters(real.machine), SECONDS)[1]
    random, paths = np.random.default_rng(5), dict[str, list[Path]]()
    for seed, trajectory in enumerate("abz", 31):
        signals = ("plant.theta", "plant.tau_meas", "feedback.tau", "reference.r")
        given = {"reference.seed": float(seed)}
        result = run(real.case(case), case.duration, signals=signals, parameters=given)
        for number in (1, 2):
            path = folder / f"{trajectory}{number}.h5"
            write_log(result, path, trajectory, number)
            with h5py.File(path, "r+") as log:
                for name, deviation in NOISE.items():
                    log[name][...] += deviation * random.standard_normal(log[name].shape)
            paths.setdefault(trajectory, []).append(path)
    return paths


@pytest.mark.slow
def test_effect_of_ones_own_is_found_and_built(folder: Path, logs: dict[str, list[Path]]) -> None:
    fitted = [str(path) for trajectory in "ab" for path in logs[trajectory]]
    words = ["diagnose", *fitted, "--held-out", *map(str, logs["z"]), "--json", "--apply"]
    words += ["--machine", str(folder / "bare.toml"), "--out", str(folder / "out")]
    done = CliRunner().invoke(app, [*words, "--effect", f"{folder / 'detent.py'}:MagneticDetent"])
    assert done.exit_code == 0, done.output
    answer: dict[str, Any] = json.loads(done.stdout)
    (effect,) = answer["effects"]
    assert (effect["id"], effect["axes"]) == ("magnetic_detent", [AXIS])
    for name, value in TRUTH.items():
        low, high = effect["parameters"][name]["ci95"]
        assert low < value < high
        assert high - low < 0.4 * value
    (use,) = load_machine(Path(answer["machine"])).effects
    assert use.id == "magnetic_detent"
    loop = answer["shown"]["closed_loop"]["model"]
    assert loop["after"]["e"] < 3.0 < loop["before"]["e"] / 10
