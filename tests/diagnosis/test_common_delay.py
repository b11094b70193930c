"""A delay of the torques is common to all axes; what the model lacks on one of them is not."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit import fit, guard
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.span import spacing_for
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

Array = NDArray[np.float64]
__all__ = ["planar"]
LATE = 6
"""Samples: more than the tolerance of a delay."""


def arm(folder: Path, base: str, late: tuple[int, int], strange: float = 0.0) -> Calibrated:
    """The fit of an arm whose torques are logged so many samples late, each axis by itself.

    strange: amplitude [N m] of a torque of the second axis that goes with its rate.
    """
    paths = []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        run = two_links.run(motion, number, 0.0, (0.0, 0.0))
        tau = run["tau_meas"]
        rate = np.gradient(run["theta"][:, 1], two_links.TS)
        tau[:, 1] += strange * np.sin(2 * rate)
        run["tau_meas"] = np.stack([np.roll(tau[:, i], late[i]) for i in (0, 1)], axis=1)
        cut = {name: values[20:-20] for name, values in run.items()}
        head = {"trajectory": str(motion), "pass": str(number)}
        paths.append(plain_csv(folder / f"{motion}{number}.csv", cut, **head))
    base_model, run_set, _ = run_set_of(paths, [], None, Options(base=base))
    return calibrate(
        base_model, blocks(base_model, run_set.runs, spacing_for(base_model, run_set.runs))
    )


def test_delay_is_found_beside_an_axis_that_the_model_does_not_explain(
    planar: str, tmp_path: Path
) -> None:
    """What is left there goes with the rate, so that this axis alone asks for another delay."""
    model = arm(tmp_path, planar, (LATE, LATE), strange=20.0)
    assert abs(model.fitted.delay - LATE * two_links.TS) < 0.1 * two_links.TS


def test_noise_of_an_axis_is_at_first_what_is_left_there(planar: str, tmp_path: Path) -> None:
    plain, strange = (arm(tmp_path, planar, (0, 0), strange=size) for size in (0.0, 20.0))
    ratio = strange.noise.scale / plain.noise.scale
    assert ratio[1] > 20
    assert ratio[0] < 2


@pytest.mark.parametrize(
    ("delay", "left", "kept"),
    [(0.5, (1.0, 1.0), True), (2.0, (0.5, 1.2), True), (2.0, (0.9, 1.0), False)],
    ids=["within its tolerance", "explains much", "explains little"],
)
def test_delay_beyond_its_tolerance_explains_much(
    delay: float, left: tuple[float, float], kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half of the product of what all axes leave without it, squared, or less stays. Another one
    begins at zero, and is free all the same."""

    def fitted(base: Any, blocks: Any, late: float) -> tuple[Any, Array]:
        free = late == 1.0
        values = Fitted(*np.zeros((3, 1)), delay if free else 0.0, late)
        return SimpleNamespace(fitted=values), np.array(left if free else (1.0, 1.0))

    monkeypatch.setattr(fit, "_calibrated", fitted)
    monkeypatch.setattr(fit, "tolerance_of_delay", lambda base, blocks: 1.0)
    monkeypatch.setattr(fit, "at_values", lambda model, values: SimpleNamespace(fitted=values))
    base: Any = None
    values = fit.calibrate(base, ()).fitted
    assert values.delay == (delay if kept else 0.0)
    assert values.late == 1.0


@pytest.mark.parametrize("whole", [True, False])
def test_what_is_left_without_a_name_may_look_like_a_delay(
    whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of one trajectory friction has no name, and is in no fit."""
    own: Any = SimpleNamespace(bench=SimpleNamespace(model=None, effects={}))
    own.bench.model = SimpleNamespace(base=SimpleNamespace(n=3))
    for name, value in {"clear": True, "beside": None, "Bench": None, "again": own}.items():
        monkeypatch.setattr(guard, name, lambda *_, value=value: value)
    monkeypatch.setattr(guard, "delay_of", lambda _: (0.052, 0.001))
    text = guard.delayed(own, 4.0, whole)
    assert text.startswith("the torque channel lags the angles by 52 ms on all axes")
    assert ("without a name looks like that" in text) != whole
