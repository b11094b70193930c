"""Runs in Python: read as on the command line, or at hand; errors in the words of the interface."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexhex
from flexhex.python_words import translated

UNITS = {"time": "ms", "theta": "deg"}
RENAME = {"t": "time", "pos": "theta[1]", "i": "current"}
READING: dict[str, Any] = {"units": UNITS, "rename": RENAME, "torque_constant": 2.0}


@pytest.fixture(name="files")
def _files(tmp_path: Path) -> list[Path]:
    """Two motions of an axis with 0.5 kg m2, in ms, degrees and amperes of 2 N m/A."""
    t, paths = np.arange(0.0, 6.0, 0.002), []
    for k in (1, 2):
        theta, rate = 0.4 * np.sin((2 + k) * t), (2 + k) * 0.4 * np.cos((2 + k) * t)
        noise = np.random.default_rng(k).normal(0, 1e-3, t.size)
        tau = -0.5 * (2 + k) ** 2 * theta + 0.3 * rate + noise
        rows = np.column_stack([1e3 * t, np.rad2deg(theta), tau / 2.0])
        paths.append(tmp_path / f"{k}.csv")
        head = "t,pos,i\n,,A"
        np.savetxt(paths[-1], rows, delimiter=",", header=head, comments="")
    return paths


def test_runs_are_read_as_by_the_command_line_or_given_as_logs(files: list[Path]) -> None:
    read = [flexhex.read_log(file, **READING) for file in files]
    named = flexhex.identify_runs(files, base="axis", **READING)
    given = flexhex.identify_runs(read, base="axis")
    assert named["J[1]"].estimate == given["J[1]"].estimate
    # smoothing of noise, and a rate by differences
    assert given["J[1]"].estimate.value == pytest.approx(0.5, rel=0.01)
    both = (flexhex.diagnose_runs(files, base="axis", **READING),
            flexhex.diagnose_runs(read, base="axis"))  # fmt: skip
    assert both[0].verdict == both[1].verdict


@pytest.mark.parametrize("function", [flexhex.identify_runs, flexhex.diagnose_runs])
def test_single_run_is_no_list(function: Callable[..., Any], files: list[Path]) -> None:
    for single in (str(files[0]), files[0]):
        with pytest.raises(flexhex.UsageError, match=r"runs = '.*1.csv': must be a list"):
            function(single, base="axis")
    with pytest.raises(flexhex.UsageError, match="held_out = one log: must be a list"):
        function(files, flexhex.read_log(files[0], **READING), base="axis")


def test_errors_name_arguments_not_options(files: list[Path]) -> None:
    with pytest.raises(flexhex.LogError, match=r"rename=\{'COLUMN': 'theta\[1\]'\}") as error:
        flexhex.identify_runs(files, base="axis")
    assert "--" not in str(error.value)


@pytest.mark.parametrize(("said", "wanted"), [
    ("or with --rename 'COLUMN=theta[1]'.", "or with rename={'COLUMN': 'theta[1]'}."),
    ("with --unit theta=UNIT (rad, deg)", "with units={'theta': 'UNIT'} (rad, deg)"),
    ("rough, with --tolerance mass=0.3", "rough, with tolerance={'mass': 0.3}"),
    ("give --torque-constant (K_t)", "give torque_constant (K_t)"),
    ("add --base with a file, or --base axis", "add base with a file, or base axis"),
    ("a dash -- and --other", "a dash -- and --other"),
])  # fmt: skip
def test_words_are_translated(said: str, wanted: str) -> None:
    assert translated(said) == wanted


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"runs": None}, "runs = None: must be a list of logs or paths"),
    ({"runs": [np.zeros(3)]}, "runs[0] is of type ndarray: must be a path, or what read_log gives"),
    ({"held_out": 5}, "held_out = '5': must be a list of logs or paths"),
    ({"base": None}, "base = None: must be a name or a path"),
    ({"joints": "shoulder,elbow"}, "joints = 'shoulder,elbow': must be a list of names"),
    ({"joints": [3]}, "joints: 3 is no name"),
    ({"tolerance": "mass=0.1"}, "tolerance = 'mass=0.1': must be a dictionary"),
    ({"tolerance": {"mass": "wide"}}, "tolerance['mass'] = 'wide': must be a number"),
    ({"units": "theta=deg"}, "units = 'theta=deg': must be a dictionary"),
    ({"units": {"theta": 5}}, "units['theta'] = 5: must be a text"),
    ({"rename": 5}, "rename = 5: must be a dictionary"),
    ({"torque_constant": "x"}, "torque_constant = 'x': must be a number above zero"),
    ({"torque_constant": float("nan")}, "torque_constant = nan: must be a number above zero"),
    ({"torque_constant": [1.0, 0.0]}, "torque_constant: 0.0 is no number above zero"),
]


@pytest.mark.parametrize("function", [flexhex.identify_runs, flexhex.diagnose_runs])
@pytest.mark.parametrize(("arguments", "text"), WRONG, ids=[w[1][:24] for w in WRONG])
def test_argument_of_a_wrong_type_is_refused_by_name(
    function: Callable[..., Any], files: list[Path], arguments: dict[str, Any], text: str
) -> None:
    with pytest.raises(flexhex.UsageError) as error:
        function(**{"runs": files, "base": "axis", **arguments})
    assert str(error.value).startswith(text)


def test_effects_are_a_list_and_settling_a_time(files: list[Path]) -> None:
    with pytest.raises(flexhex.UsageError, match=r"effects = 'e\.py:X': must be a list of names"):
        flexhex.diagnose_runs(files, base="axis", effects="e.py:X")
    for settle in (-1, "x"):
        with pytest.raises(flexhex.UsageError, match=r"settle = .*: must be a number"):
            flexhex.identify_runs(files, base="axis", settle=settle)  # type: ignore[arg-type]
