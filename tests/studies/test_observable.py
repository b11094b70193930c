"""How much of what is hidden in MuJoCo's machines the base model's own parameters leave."""

from __future__ import annotations

from dataclasses import replace

import pytest

from studies.mujoco import draw as drawing
from studies.mujoco.draw import draw
from studies.mujoco.runs import runs_of
from studies.mujoco.truth import truth_of
from tests.studies.test_mujoco import FEW, hidden, quiet


@pytest.fixture(autouse=True)
def _short_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "MOST_STEPS", FEW)


def test_what_the_base_model_can_take_up_is_not_observable() -> None:
    axis = truth_of(hidden("viscous_friction", "axis"))["beside"][0]
    arm = truth_of(hidden("viscous_friction", "arm"))["hidden"][0]
    assert axis["size"] > 0.03
    assert axis["observable"] < 1e-3 * axis["size"]
    assert arm["observable"] > 0.1 * arm["size"]
    assert arm["observable_beside_friction"] < 1e-3 * arm["size"]


def test_a_delay_of_all_axes_is_the_loggers() -> None:
    """However long: a single axis has no other one to compare with."""
    axis = truth_of(hidden("time_delay", "axis"))["hidden"][0]
    gantry = truth_of(hidden("time_delay", "gantry"))["hidden"][0]
    assert axis["size"] > 0.01
    assert axis["observable"] < 1e-6 * axis["size"]
    assert gantry["observable"] > 0.1 * gantry["size"]


def test_a_changed_rotor_is_observable_as_far_as_no_other_parameter_makes_up_for_it() -> None:
    case = quiet(draw(3070))
    assert case.changes[0]["kind"] == "armature"

    def observable_with(mass_error: float) -> float:
        (change,) = truth_of(runs_of(replace(case, mass_error=mass_error)))["changed"]
        return float(change["observable"])

    exact, usual, vague = (observable_with(error) for error in (0.0, 0.02, 10.0))
    assert 0.5 * usual > vague
    assert exact > usual > 0.3 * exact
