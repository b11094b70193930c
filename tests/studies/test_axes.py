"""Plain axes: what is written is what the truth says, found again without the library."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from studies.axes import Case, cogging, draw, presliding, runs_of
from studies.axes_files import write


def small(seed: int) -> Case:
    """A case with short runs."""
    case = draw(seed)
    return replace(case, seconds=1.2 / case.pace, rate=250.0)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_least_squares_with_the_true_columns_finds_friction_and_no_delay(seed: int) -> None:
    """Shape of the friction and order of the cogging as in the truth; all else free."""
    case = small(seed)
    (run, _), *_ = runs_of(case)
    for i in range(case.n):
        q, v, a, u = (getattr(run, x)[:, i] for x in ("q", "v", "a", "u"))
        waves = [f(k * case.order * q) for k in range(1, 4) for f in (np.cos, np.sin)]
        late = np.gradient(u, 1 / case.rate)
        X = np.stack([np.ones_like(q), a, v, run.z[:, i], *waves, late], axis=1)
        size = np.linalg.norm(X, axis=0)
        result = np.linalg.lstsq(X / size, u, rcond=None)[0] / size
        assert result[3] == pytest.approx(case.friction[i], rel=0.05)
        assert result[2] == pytest.approx(case.damping[i], rel=0.1)
        assert abs(result[-1]) < 1e-3, "a delay"


def test_cogging_has_whole_periods_in_a_turn_and_its_harmonics() -> None:
    case = draw(4)
    q = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)[:, None] * np.ones(case.n)
    spectrum = np.abs(np.fft.rfft(cogging(case, q)[:, 0])) / 10_000
    large = np.flatnonzero(spectrum > 1e-6 * spectrum.max())
    assert large.tolist() == [k * case.order for k in range(1, len(case.heights) + 1)]
    np.testing.assert_allclose(spectrum[large] / case.cogging[0], case.heights, rtol=1e-9)


def test_friction_turns_within_its_width_whatever_the_steps() -> None:
    q = np.concatenate([np.linspace(0, 1, 11), np.linspace(1, 0.5, 301)])[:, None]
    z = presliding(q, np.array([0.01]))[:, 0]
    assert z[10] == pytest.approx(1.0)
    turned = 1 - 2 * (1 - np.exp(-(1 - q[11:, 0]) / 0.01))
    np.testing.assert_allclose(z[11:], turned, atol=1e-9)


def test_draws_cover_orders_and_strokes() -> None:
    cases = [draw(seed) for seed in range(400)]
    turns = [case.stroke / (2 * np.pi) for case in cases]
    assert min(turns) < 0.1
    assert max(turns) > 15
    assert min(case.order for case in cases) <= 2
    assert max(case.order for case in cases) > 400
    assert {case.n for case in cases} == {1, 2, 3}
    assert repr(draw(7)) == repr(cases[7])


def test_what_is_written_is_the_motion_of_the_truth(tmp_path: Path) -> None:
    case = small(2)
    written = write(case, tmp_path / "logs", tmp_path / "sealed")
    assert (len(written.paths), len(written.test_paths)) == (4, 2)
    truth = json.loads(written.sealed.read_text())
    assert [h["id"] for h in truth["hidden"]] == ["coulomb_friction", "cogging_harmonic"]
    with h5py.File(written.paths[0]) as file:
        assert file["theta"].attrs["unit"] == "rad"
        theta, torque = np.array(file["theta"]), np.array(file["tau_meas"])
    first = len(runs_of(case)[0][0].q) - len(theta)
    run = runs_of(case)[0][0]
    np.testing.assert_allclose(theta, run.q[first:], atol=case.encoder)
    np.testing.assert_allclose(torque.std(axis=0), run.u[first:].std(axis=0), rtol=0.01)
    whole = np.linalg.norm(truth["torque_rms"])
    for h in truth["hidden"]:
        assert 0 < h["observable"] <= h["size"] < 1
        per_axis = np.array(h["observable_per_axis"]) * np.array(truth["torque_rms"])
        assert np.linalg.norm(per_axis) / whole == pytest.approx(h["observable"])
