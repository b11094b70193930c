"""Parameters of components over those of the .ssp: numbers, flags, items of enumerations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.ssp.executor import run
from tests.gateway.test_system import rows, same
from tests.gateway.test_system_refusals import refusal


def test_parameters_are_set_by_item_and_by_flag(hexapod_ssp: Path, tmp_path: Path) -> None:
    """As in the simulation: another motion, and one parameter that does not adapt."""
    values = {"reference.kind": "multisine", "reference.t_start": 0.0, "K.t_start": 0.0}
    p = "p.actuator[1].o"
    frozen = values | {f"K.adapt.{p[2:]}": "false"}
    starts = {}
    for name, chosen in {"adapting": values, "frozen": frozen}.items():
        words = [w for key, value in chosen.items() for w in ("--set", f"{key}={value}")]
        ours = rows(tmp_path / "rows", [f"K.{p}"], hexapod_ssp, "--seconds", 0.5, *words)
        theirs = run(hexapod_ssp, 0.5, signals=["plant.theta"], parameters=chosen)["plant.theta"]
        assert same(ours["theta"], theirs[: len(ours["theta"])])
        starts[name] = ours
    assert np.ptp(starts["adapting"][f"K.{p}"]) > 0.0
    assert np.ptp(starts["frozen"][f"K.{p}"]) == 0.0
    assert np.ptp(starts["frozen"]["theta"]) > 0.01  # the reference as it stands rests for 2 s


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("feedback.kp[9]=1", "parameter 'feedback.kp[9]': there is no variable"),
        ("feedback.kp[1]=nan", "feedback: kp[1] = NaN, must be a finite number"),
        ("feedback.kp[1]=true", "feedback: kp[1] = true, must be a finite number"),
        ("reference.kind=chrip", "no item 'chrip', did you mean 'chirp'?"),
        ("reference.kind=7", "kind = 7, must be one of 0 setpoints, 1 triangle, 2 "),
        ("reference.kind=true", "kind = true, must be one of 0 setpoints"),
        ("reference.passes=1.5", "passes = 1.5, must be a whole number"),
        ("reference.passes=3e9", "passes = 3000000000, must be a whole number"),
        ("feedback.tau[1]=1", "'feedback.tau[1]': is of causality output, not a parameter"),
        ("K.adapt.end_effector.m=2", "adapt.end_effector.m = 2, must be 0, 1, true or false"),
        ("K.adapt.end_effector.m=on", "adapt.end_effector.m = on, must be 0, 1, true or false"),
        ("plnat.Ts=1", "parameter 'plnat.Ts': there is no component 'plnat'"),
        ("kp=1", "parameter 'kp': write it as component.parameter"),
        ("K.Ts=0.0001", "K: Ts = 0.0001 s is 0.4 base steps of 0.00025 s"),
    ],
)
def test_a_parameter_is_refused_in_words(setting: str, said: str, hexapod_ssp: Path) -> None:
    assert said in refusal(hexapod_ssp, "--set", setting)
