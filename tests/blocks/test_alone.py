"""Each FMU alone in FMPy: it starts as the nominal machine at rest, and as its README shows."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu

from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmus.common.interface import array_of
from results.plots import DRAWN, plot
from tests.conftest import ROOT
from tests.test_documents import blocks


@pytest.mark.parametrize("name", [*BLOCKS, "machine"])
def test_lines_of_the_readme_print_what_they_say(fmu_dir: Path, name: str) -> None:
    text = (ROOT / "fmus" / name / "README.md").read_text(encoding="utf-8")
    (code,), (wanted,) = blocks(text, "python"), blocks(text, "text")
    # the machine's lines run plant.fmu beside it, by name
    assert f"out/fmus/{name}.fmu" in code or "out/fmus/{name}.fmu" in code
    assert len(code.splitlines()) <= 12
    here = code.replace("out/fmus", str(fmu_dir))
    done = subprocess.run([sys.executable, "-c", here], capture_output=True, text=True, check=False)
    said = [line for line in done.stdout.splitlines() if "missing input" not in line]
    assert said == wanted.splitlines(), done.stderr[-2000:]


NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
DOT = 0.15
"""How far a point may stand elsewhere [dots], which are rounded to a tenth: other compilers round
other last bits."""


def assert_same_picture(one: str, other: str) -> None:
    """The same text, numbers within a dot's rounding."""
    assert NUMBER.sub("0", one) == NUMBER.sub("0", other)
    numbers = [np.array([float(n) for n in NUMBER.findall(text)]) for text in (one, other)]
    assert np.allclose(*numbers, rtol=0, atol=DOT)


@pytest.mark.parametrize("name", DRAWN)
def test_plot_of_the_readme_is_what_its_lines_return(fmu_dir: Path, name: str) -> None:
    """Else: `flexhex build`, then `python -m results.plots`."""
    kept = (ROOT / "fmus" / name / "plot.svg").read_text(encoding="utf-8")
    assert_same_picture(plot(name, fmu_dir), kept)
    readme = (ROOT / "fmus" / name / "README.md").read_text(encoding="utf-8")
    assert readme.count("](plot.svg)") == 1


def test_other_pictures_differ() -> None:
    kept = (ROOT / "fmus" / "plant" / "plot.svg").read_text(encoding="utf-8")
    assert_same_picture(kept, kept)
    for old, new in (("tau = 0", "tau = 1"), ("[m]", "[mm]"), ('y="19"', 'y="20"')):
        with pytest.raises(AssertionError):
            assert_same_picture(kept, kept.replace(old, new, 1))


def starts(fmu: Path, array: str) -> list[float]:
    """Start values of an array."""
    listed = read_model_description(str(fmu)).modelVariables
    return [float(v.start) for v in listed if array_of(v.name) == array]


def test_plant_rests_for_its_whole_default_experiment(fmu_dir: Path) -> None:
    """With tau = 0 it had fallen onto its stops within 0.34 s."""
    names = [f"theta[{k}]" for k in range(1, 7)]
    rows = simulate_fmu(str(fmu_dir / "plant.fmu"), output=["fault", *names])
    assert rows["time"][-1] == 10.0
    assert not rows["fault"].any()
    # cogging and friction hold it near the pose; a tenth of a degree
    assert max(np.abs(rows[name]).max() for name in names) < 2e-3


def test_all_fmus_start_at_the_torque_that_holds_the_nominal_machine(fmu_dir: Path) -> None:
    holding = starts(fmu_dir / "plant.fmu", "tau")
    inputs = {"feedback": "tau_ff", "filter": "tau_meas", "estimator": "tau_f", "machine": "tau"}
    for name, array in inputs.items():
        assert starts(fmu_dir / f"{name}.fmu", array) == holding, name
    torques = [f"tau_ff[{k}]" for k in range(1, 7)]
    rows = simulate_fmu(str(fmu_dir / "feedforward.fmu"), stop_time=0.01, output=torques)
    # start values have six decimals
    assert np.allclose([rows[name][-1] for name in torques], holding, rtol=0, atol=5e-7)
    assert min(np.abs(holding)) > 0.1, "nothing was held"


def test_feedforward_and_estimator_start_with_the_same_parameters(fmu_dir: Path) -> None:
    p = starts(fmu_dir / "feedforward.fmu", "p")
    assert p == starts(fmu_dir / "estimator.fmu", "p0")
    assert len(p) == 162


def test_estimator_at_rest_has_nothing_to_learn(fmu_dir: Path) -> None:
    """All of its inputs are of one machine: the innovation is what six decimals leave over."""
    names = [f"innovation[{k}]" for k in range(1, 7)]
    rows = simulate_fmu(str(fmu_dir / "estimator.fmu"), stop_time=1.0, output=names)
    assert max(np.abs(rows[name]).max() for name in names) < 5e-7
