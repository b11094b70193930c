"""What changed in a robot beside friction that its file lacks."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from flexhex.diagnosis.workflow import Options, diagnose
from tests.compare import assert_close
from tests.diagnosis.robots.simulated import DRY, FILE, Change, write

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")


def tilted(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = 9.81 * np.array([0.0, np.sin(0.035), -np.cos(0.035)])


def heavier(model: mujoco.MjModel) -> None:
    model.body_mass[4] *= 3.0
    model.body_inertia[4] *= 3.0


CHANGES: dict[str, tuple[Change, str, float, float]] = {
    "tilt": (tilted, "gravity.x", 0.035, 0.002),
    "mass": (heavier, "link_4.m", 3.0 * 2.0, 0.6),
}
"""What makes it, the parameter that says so, its size and how well it is known."""


@pytest.mark.sample(1, of="changes beside friction")
@pytest.mark.parametrize("case", CHANGES)
def test_change_beside_friction_is_reported(case: str, tmp_path: Path) -> None:
    """Friction gains a hundred times as much. What its form may leave is compared with what is not
    explained at all, not with what friction gains."""
    change, name, size, error = CHANGES[case]
    paths = [
        write(tmp_path / f"{s}_{k}.csv", s, k, DRY, change, noise=0.02)
        for s in (1, 2)
        for k in (1, 2)
    ]
    diagnosis = diagnose(paths, options=Options(base=str(FILE)))
    assert [effect.id for effect in diagnosis.effects] == ["coulomb_friction"]
    found = {changed.parameter: changed.estimate for changed in diagnosis.changed}
    assert name in found
    assert_close(abs(found[name].value), size, atol=error)


def drawn(model: mujoco.MjModel) -> None:
    """Bodies as a file is off that was drawn, not weighed: masses by a factor of two and more."""
    rng = np.random.default_rng(1)
    times = np.exp(rng.uniform(-1.0, 1.0, model.nbody))
    model.body_mass *= times
    model.body_inertia *= times[:, None]
    model.body_ipos += rng.normal(0.0, 0.02, (model.nbody, 3))


def test_friction_is_named_beside_a_file_of_which_little_is_true(tmp_path: Path) -> None:
    """That the file is off is said, and no effect stands in for it."""
    runs = [(s, k) for s in (1, 2, 3) for k in (1, 2)]
    paths = [write(tmp_path / f"{s}_{k}.csv", s, k, DRY, drawn, noise=0.02) for s, k in runs]
    diagnosis = diagnose(paths[:4], paths[4:], options=Options(base=str(FILE)))
    assert [(e.id, e.axes) for e in diagnosis.effects] == [("coulomb_friction", (3,))]
    assert diagnosis.changed
    left, noise = diagnosis.residual.after, diagnosis.residual.non_repeatable
    assert (left[[0, 1, 3, 4, 5]] < 2.0 * noise[[0, 1, 3, 4, 5]]).all()
