"""The fit of the base model: clocks, noise and rests, where the model lacks something."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import joint
from flexhex.diagnosis.jointfit.beside import beside
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.blocks import torque_at, torque_rms
from flexhex.diagnosis.runs.noise import INEXACT, Noise, calmed, line, measured, unweighted
from flexhex.diagnosis.runs.rests import moving
from flexhex.diagnosis.runs.run import TimeSeries
from tests.diagnosis.single import SECONDS, TS, moved, wanted, write

Array = NDArray[np.float64]
CLOCK = np.arange(round(SECONDS / TS)) * TS
RMS = float(wanted(CLOCK, 1).std())
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2))
Torque = Callable[[Array, Array, Array], Array]
"""Of angle, rate, acceleration."""


def calibrated_of(
    folder: Path, torque: Torque, late: int = 0, offsets: Sequence[float] = (), **more: float
) -> Calibrated:
    """Base model of an axis that feels a further torque [N m]; late: samples by which the torques
    are logged too late; offsets [N m]: of each run."""
    paths = []
    for k, (motion, number) in enumerate(RUNS):
        whole = wanted(CLOCK, motion)
        own = torque(*moved(CLOCK, motion)) + (offsets[k] if offsets else 0.0)
        extra = np.roll(whole + own, late) - whole
        path = folder / f"{k}.csv"
        paths.append(write(path, motion, number, 0.0, extra=extra, **more))  # type: ignore[arg-type]
    base, run_set, trouble = run_set_of(paths, [], None, Options(base="axis"))
    assert not trouble
    return fitted(base, run_set.runs)[0]


def nothing(q: Array, v: Array, a: Array) -> Array:
    return np.zeros_like(q)


def test_noise_of_the_angles_is_no_delay(tmp_path: Path) -> None:
    """A slow motion over many poles says little of a delay, the noise of its acceleration,
    differentiated once more, nothing at all: less than a sample."""
    t, paths = np.arange(10000) * 2e-3, []
    for k, motion in enumerate((1, 1, 2, 2)):
        w = 2 * np.pi * np.array([0.05, 0.1, 0.17]) * (1 + 0.1 * motion)
        size, phase = np.array([6.0, 3.0, 1.0]), motion * np.array([0.3, 1.0, 2.0])
        q = np.sin(w * t[:, None] + phase) @ size
        tau = -0.27 * np.sin(w * t[:, None] + phase) @ (size * w**2) + 0.02 * np.sin(60 * q)
        rng = np.random.default_rng(k)
        columns = q + 1e-5 * rng.standard_normal(len(t)), tau + 2e-3 * rng.standard_normal(len(t))
        head = f"# trajectory: {motion}\n# pass: {k % 2 + 1}\ntime,theta[1],tau_meas[1]\ns,rad,N m"
        path = tmp_path / f"{k}.csv"
        np.savetxt(path, np.column_stack([t, *columns]), "%.8f", ",", header=head, comments="")
        paths.append(path)
    base, run_set, _ = run_set_of(paths, [], None, Options(base="axis"))
    assert abs(fitted(base, run_set.runs)[0].fitted.delay) < 2e-3


@pytest.mark.parametrize("late", [0, 6])
def test_dry_friction_is_no_delay(late: int, tmp_path: Path) -> None:
    model = calibrated_of(tmp_path, lambda q, v, a: 0.1 * RMS * np.tanh(v / 0.01), late)
    assert model.fitted.delay == pytest.approx(late * TS, abs=0.3 * TS)


def test_friction_that_nobody_found_is_no_delay_beside_what_was(tmp_path: Path) -> None:
    model = calibrated_of(tmp_path, lambda q, v, a: RMS * (0.2 * np.tanh(v / 0.01) + 0.2 * v))
    again = beside(joint(Bench(model, []), []))
    assert again.fitted.delay == pytest.approx(0.0, abs=0.3 * TS)


def test_machine_file_is_compared_once_the_clocks_are_brought_together(tmp_path: Path) -> None:
    """The file of a plain axis says that nothing is known: all torque is left, as late as it is."""
    model = calibrated_of(tmp_path, nothing, 7)
    assert model.fitted.delay == pytest.approx(7 * TS, abs=0.1 * TS)
    assert np.count_nonzero(model.nominal) == 1
    for block, left in zip(model.blocks, model.residual(model.nominal), strict=True):
        torque = torque_at(block, model.base.window, model.fitted.delay)
        np.testing.assert_allclose(left, torque, atol=1e-9)


def bare(residual: list[Array], repeats: bool) -> Noise:
    """Noise of residuals (m, 1) of runs with a torque of about 1 N m."""
    rng, size = np.random.default_rng(5), len(residual[0])
    signal = TimeSeries(0.0, 1e-3, rng.standard_normal((size, 1)), np.ones(size, bool))
    names = ["a" if repeats else k for k in range(len(residual))]
    runs = [SimpleNamespace(trajectory=k, tau=signal, repeated=(k, 0)) for k in names]
    judged = np.ones((size, 1), dtype=bool)
    blocks: Any = [SimpleNamespace(run=run, judged=judged) for run in runs]
    return measured(blocks, residual)


def test_no_noise_is_quieter_than_the_model_is_good() -> None:
    """Slow noise of a thousandth: its whitening would trust what is fast a hundred times more."""
    rng = np.random.default_rng(5)
    slow = 1e-3 * np.cumsum(rng.standard_normal((2000, 1)), axis=0) / 40
    noise = bare([slow, -slow], repeats=True)
    assert noise.scale[0] > INEXACT
    assert unweighted(noise, np.ones(1, dtype=bool)).scale[0] > INEXACT > noise.rms[0]
    assert abs(noise.a[0].sum()) < 0.3


def test_offsets_of_runs_are_noise_of_runs_alone(tmp_path: Path) -> None:
    """Rows are about as sure as without them, a run's own mean is not."""
    ways = (0.003, -0.003, -0.003, 0.003)
    kinds = {"none": (), "own": ways}
    models = {k: calibrated_of(tmp_path, nothing, offsets=v, noise=0.02) for k, v in kinds.items()}
    slow = {k: m.noise.slow[0, 0] for k, m in models.items()}
    assert slow["own"] > 3 * slow["none"]
    rows = {k: [np.ones((len(b.at), 1)) for b in m.blocks] for k, m in models.items()}
    sure = {k: np.linalg.norm(m.white(0, rows[k])) for k, m in models.items()}
    assert sure["own"] < 0.3 * sure["none"]


@pytest.mark.parametrize("repeats", [False, True])
def test_what_is_slow_is_noise_only_where_passes_show_it(repeats: bool) -> None:
    """What wanders within a run and from run to run may be the model's error, if none repeats."""
    rng = np.random.default_rng(6)
    walks = [0.05 * np.cumsum(rng.standard_normal((2000, 1)), axis=0) for _ in range(4)]
    noise = bare([w + offset for w, offset in zip(walks, (3, -3, 3, -3), strict=True)], repeats)
    assert noise.repeats == repeats
    assert bool(noise.white[0]) != repeats
    if not repeats:
        assert noise.scale[0] == pytest.approx(noise.rms[0], rel=1e-3)
        assert (noise.slow == 1.0).all()


def test_line_is_orthonormal_in_the_rows_that_are_good() -> None:
    good = np.arange(50) % 7 != 0
    base = line(good)
    np.testing.assert_allclose(base.T @ base, np.eye(2), atol=1e-12)
    assert not base[~good].any()
    for straight in (np.ones(50), np.arange(50.0)):
        left = straight - base @ (base.T @ straight)
        np.testing.assert_allclose(left[good], 0, atol=1e-12)


def test_what_friction_carries_at_rest_moves_no_offset() -> None:
    """Rows of a run that are a constant and a slope where the axis moves, and anything at rest."""
    moving = np.ones(200, dtype=bool)
    moving[80:120] = False
    time = np.arange(200.0)
    rows = np.where(moving, 3.0 + 0.01 * time, 60.0)[:, None]
    slow = np.array([1e9, 1e9])
    base = line(moving)
    np.testing.assert_allclose(calmed(rows.copy(), slow, base, moving), 0.0, atol=1e-6)
    own = calmed(rows.copy(), np.ones(2), base, moving)[:, 0]
    np.testing.assert_array_equal(own, np.where(moving, rows[:, 0], 0.0))
    never = np.zeros(200, dtype=bool)
    assert not calmed(rows.copy(), slow, line(never), never).any()


def resting(angle: Array, rate: Array, spacing: float) -> NDArray[np.bool_]:
    """Rows (m,) in which one axis moves."""
    faster = np.gradient(rate, spacing)
    motion = angle[:, None], rate[:, None], faster[:, None]
    usable = np.ones(len(angle), dtype=bool)
    return moving([motion], [usable], 4 * spacing, spacing)[0][:, 0]


def test_axis_that_stands_says_nothing_nor_do_rows_next_to_it() -> None:
    t = np.arange(400) * 0.01
    rate = np.where((t > 1) & (t < 2), 0.0, np.sin(5 * t) + 2.0)
    there = resting(np.cumsum(rate) * 0.01, rate, 0.01)
    still = np.flatnonzero(~there)
    assert still[0] == pytest.approx(100, abs=4)
    assert still[-1] == pytest.approx(200, abs=4)
    assert still[0] < 101
    assert still[-1] > 199


def test_axis_that_creeps_on_purpose_moves() -> None:
    t = np.arange(1000) * 0.01
    rate = np.where(t > 5, 0.02, np.cos(t))
    assert resting(np.cumsum(rate) * 0.01, rate, 0.01).all()


@pytest.mark.parametrize("pace", [0.3, 9.0])
def test_oscillation_does_not_rest(pace: float) -> None:
    """However slowly it turns."""
    t = np.arange(6000) * 0.01
    assert resting(-np.cos(pace * t) / pace, np.sin(pace * t), 0.01).all()


def test_torque_of_all_runs_is_measured_about_their_common_mean() -> None:
    """Some samples of one run are invalid, and all of another."""
    rng = np.random.default_rng(3)
    valid = [rng.random(500) < share for share in (1.0, 0.7, 0.0)]
    signals = [TimeSeries(0.0, 1e-3, rng.normal(size=(500, 2)) + k, v) for k, v in enumerate(valid)]
    blocks: Any = [SimpleNamespace(run=SimpleNamespace(tau=signal)) for signal in signals]
    whole = np.concatenate([signal.values[signal.valid] for signal in signals])
    assert torque_rms(blocks) == pytest.approx(whole.std(axis=0), rel=1e-12)
