"""`flexhex identify`: the table, and what --write leaves in a file."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.errors import FlexhexError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.identify.view import print_fit, with_deviation
from flexhex.identify.write import beside, checked_target, write_fit
from tests.conftest import MACHINE_FILE

STD = 1e-4


@pytest.fixture
def fit(machine: Machine) -> Fit:
    """A fit of the machine file's values, all with one small deviation and no correlation."""
    p = base_parameters(machine)
    std = np.full(len(p), STD)
    return Fit(p, std, np.zeros(6), 1.0, 10, (), covariance=np.diag(std**2))


def moved(machine: Machine, fit: Fit, **by: float) -> Fit:
    """The fit with some parameters elsewhere."""
    names = [par.name for par in parameters(machine)]
    p = fit.p.copy()
    for name, shift in by.items():
        p[names.index(name)] += shift
    return replace(fit, p=p)


def test_table_groups_bodies_and_counts_what_is_not_determined(
    machine: Machine, fit: Fit, capsys: pytest.CaptureFixture[str]
) -> None:
    fitted = moved(machine, fit, **{"actuator[1].o": 3 * STD, "actuator[2].a[3]": -7 * STD})
    print_fit(machine, replace(fitted, undetermined=("actuator[1].k", "actuator[4].b[2]")))
    text = capsys.readouterr().out
    (row,) = [line for line in text.splitlines() if line.strip().startswith("actuator[1].o")]
    assert row.split() == ["actuator[1].o", "-1.49970", "±", "0.00010", "-1.5", "+3.0", "N", "m"]
    assert "most: actuator[2].a[3]" in text
    assert "-7.0" in text
    assert "actuator[1].k *" in text
    assert "2 of 162 parameters are not determined" in text
    assert "actuator[2].a[4]" not in text
    print_fit(machine, fitted, every=True)
    assert "actuator[2].a[4]" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (1.23456, 0.034, "1.23 ± 0.03"),
        (1.23456, 0.0123, "1.235 ± 0.012"),
        (-120.4, 34.0, "-120 ± 34"),
        (0.5, 0.0, "0.5"),
    ],
)
def test_digits_of_a_value_are_those_of_its_deviation(value: float, std: float, text: str) -> None:
    assert with_deviation(value, std) == text


def test_machine_file_holds_the_fit(machine: Machine, fit: Fit, tmp_path: Path) -> None:
    """Small differences of all kinds come back from the written file as they were fitted."""
    shifts = {
        "actuator[2].o": 0.1,
        "actuator[1].a[3]": 0.01,
        "flexure.k_s1": 0.02,
        "end_effector.m": 0.05,
    }
    arms = {f"upper.J[{k}]": 2e-4 for k in range(1, 7)}
    fitted = moved(machine, fit, **shifts, **arms, **{"upper.mc_x": 1e-3, "lower.J_yy": 1e-5})
    path = tmp_path / "fitted.toml"
    assert write_fit(path, MACHINE_FILE, machine, fitted, [Path("run.h5")]) == []
    assert base_parameters(load_machine(path)) == pytest.approx(fitted.p, abs=1e-12)
    assert path.read_text(encoding="utf-8").count('source = "fitted"') > 10


def test_what_no_machine_can_have_stays_the_files(
    machine: Machine, fit: Fit, tmp_path: Path
) -> None:
    """A negative damping stays, and so does a lower arm whose inertia no body has, as a whole; the
    mean of the upper arms is written. What is not determined is not taken either."""
    wrong = {
        "actuator[5].d": -0.02,
        "lower.J_xx": -1e-3,
        "lower.mc_y": 1e-4,
        "actuator[1].k": 0.3,
        "upper.J[1]": 6e-5,
    }
    fitted = replace(moved(machine, fit, **wrong), undetermined=("actuator[1].k",))
    path = tmp_path / "fitted.toml"
    (text,) = write_fit(path, MACHINE_FILE, machine, fitted, [Path("run.h5")])
    for name in ("actuator[5].d", "actuator[1].k", "lower.J_xx", "lower.mc_y", "lower.J_zz"):
        assert name in text
    expected = base_parameters(machine)
    expected[
        [k for k, par in enumerate(parameters(machine)) if par.name.startswith("upper.J[")]
    ] += 1e-5
    assert base_parameters(load_machine(path)) == pytest.approx(expected, abs=1e-12)


def test_what_is_kept_moves_its_partners(machine: Machine, fit: Fit) -> None:
    """The best fit with one parameter kept, against the normal equations without it."""
    rng = np.random.default_rng(1)
    names = [par.name for par in parameters(machine)]
    root = np.eye(len(names)) + 0.1 * rng.standard_normal((len(names), len(names)))
    information = root.T @ root
    p = fit.p + rng.standard_normal(len(names))
    at = names.index("actuator[1].k")
    fitted = beside(
        machine,
        replace(fit, p=p, covariance=np.asarray(np.linalg.inv(information), dtype=np.float64)),
        {"actuator[1].k"} | {f"upper.J[{k}]" for k in range(1, 7)},
    )
    kept = np.array([at, *(names.index(f"upper.J[{k}]") for k in range(1, 7))])
    free = np.setdiff1d(np.arange(len(names)), kept)
    file = base_parameters(machine)
    part = information[np.ix_(free, kept)] @ (file[kept] - p[kept])
    expected = p[free] - np.linalg.solve(information[np.ix_(free, free)], part)
    assert fitted.p[kept] == pytest.approx(file[kept], abs=1e-9)
    assert fitted.p[free] == pytest.approx(expected, abs=1e-6)


def test_table_file_holds_every_value(machine: Machine, fit: Fit, tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    assert write_fit(path, MACHINE_FILE, machine, fit, []) == []
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["value"]) for row in rows] == fit.p.tolist()
    assert rows[0] == {"name": "actuator[1].o", "unit": "N m", "value": "-1.5", "std": "0.0001"}


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("p.txt", r"p\.txt: write \.toml for a machine file"),
        ("/proc/none/p.csv", "cannot be written"),
        (str(MACHINE_FILE), "is the machine file itself"),
    ],
)
def test_file_that_cannot_be_written_is_refused_first(
    name: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(FlexhexError, match=message):
        checked_target(tmp_path / name, MACHINE_FILE)
