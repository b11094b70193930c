"""Each FMU answers recorded inputs as it did when the golden results were written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from flexhex.fmus.common.interface import array_of
from flexhex.ssp.executor import run
from flexhex.ssp.read import read_ssp
from tests.conftest import MACHINE_FILE, ROOT
from tests.golden.golden import FOLDER, Table, play, read, write

# FMU -> instance whose inputs are recorded, first tick, number of rows, ticks that each row is
# held (the reference moves after 2 s only, the estimator adapts after 0.3 s only)
RECORDED = {
    "reference": ("reference", 0, 40, 300),
    "pose": ("reference", 8800, 20, 30),
    "kinematics": ("N_E", 4400, 16, 1),
    "feedforward": ("F", 4400, 10, 1),
    "feedback": ("feedback", 8800, 40, 1),
    "plant": ("plant", 8800, 40, 1),
    "filter": ("W", 4400, 24, 1),
    "estimator": ("K", 70, 6, 3),
}
ALONG_POSES = ("pose",)
"""FMUs whose inputs are recorded along a trajectory of poses."""
# Straight-line code with the same operations in the same order: what differs between compilers
# and C libraries is the last bit of sin, cos, exp and sqrt. 1e-9 of the largest value of an array
# is far above that and far below any change of an equation.
RTOL = 1e-9


@pytest.fixture(scope="module")
def inputs(
    request: pytest.FixtureRequest, hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Table] | None:
    """Inputs of every FMU from the adaptive loop, only when golden results are updated."""
    if not request.config.getoption("--update"):
        return None
    from flexhex.trajectory.variant import with_trajectory

    folder = tmp_path_factory.mktemp("golden")
    poses = with_trajectory(hexapod_ssp, ROOT / "examples/motion.csv", MACHINE_FILE, folder).path
    others = [fmu for fmu in RECORDED if fmu not in ALONG_POSES]
    return recorded_inputs(hexapod_ssp, others) | recorded_inputs(poses, ALONG_POSES)


def recorded_inputs(ssp: Path, fmus: Sequence[str]) -> dict[str, Table]:
    """Inputs of FMUs from a run of their system."""
    package = read_ssp(ssp)
    everything = [instance.name for instance in package.instances]
    result = run(ssp, 2.4, signals=everything)
    tables = {}
    for fmu in fmus:
        instance, first, count, _ = RECORDED[fmu]
        period = round(float(package.instance(instance).parameters["Ts"]) / package.base)
        wires = [w for w in package.wires if w.target == instance]
        columns = []
        for wire in wires:
            signal = f"{wire.source}.{wire.output}"
            values = result[signal]
            source = result.group(signal).period
            at = (first + np.arange(count)) * period // source
            columns.append(values[at])
        rows = np.column_stack(columns) if columns else np.zeros((count, 0))
        tables[fmu] = ([w.input for w in wires], rows)
    return tables


@pytest.mark.parametrize("fmu", RECORDED)
def test_fmu_answers_as_recorded(fmu: str, fmu_dir: Path, inputs: dict[str, Table] | None) -> None:
    given, wanted = FOLDER / f"{fmu}.in.csv", FOLDER / f"{fmu}.out.csv"
    if inputs is not None:
        names, rows = inputs[fmu]
        write(given, names, rows)
        write(wanted, *play(fmu_dir / f"{fmu}.fmu", names, rows, RECORDED[fmu][3]))
    names, rows = read(given)
    outputs, answers = play(fmu_dir / f"{fmu}.fmu", names, rows, RECORDED[fmu][3])
    recorded, expected = read(wanted)
    assert outputs == recorded, "outputs were renamed: `make golden` if that is wanted"
    assert answers.shape == expected.shape
    arrays = np.array([array_of(name) for name in outputs])
    for name in dict.fromkeys(arrays):
        mine, theirs = answers[:, arrays == name], expected[:, arrays == name]
        worst = np.abs(mine - theirs).max()
        assert worst <= RTOL * np.abs(theirs).max() + 1e-15, f"{name} differs by {worst:.3g}"
        assert np.isfinite(mine).all(), name
    assert np.ptp(answers, axis=0).max() > 0, "nothing happens in this recording"
