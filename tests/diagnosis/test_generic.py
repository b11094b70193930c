"""Functions without a name: their columns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.selection.generic import FINE, generic
from flexhex.diagnosis.selection.generic_scores import generic_score
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.rows import Rows
from tests.diagnosis.test_selection import bench_of


def test_function_of_the_angle_is_smoothed_like_the_torque(tmp_path: Path) -> None:
    """Any function between its places: an axis may pass a narrow one within a window, and of its
    smoothed angle the function would be another."""
    rows = Rows.of(bench_of(tmp_path, None).model)
    hypothesis = generic(rows, 0)[0]
    assert hypothesis.argument == "angle"
    blocks = rows.model.blocks
    angles = [block.run.motion.theta[:, 0] for block in blocks]
    seen = [b.few(v) for v, b in zip(angles, blocks, strict=True)]
    values = np.random.default_rng(1).normal(size=FINE)
    knots = np.linspace(min(v.min() for v in seen), max(v.max() for v in seen), FINE)
    smooth = rows.raw(
        [b.few.smooth(np.interp(v, knots, values)) for v, b in zip(seen, blocks, strict=True)]
    )
    assert hypothesis.raw @ values == pytest.approx(rows.torque_rms[0] * smooth, abs=1e-9)
    whole = rows.raw(
        [b.smooth(np.interp(v, knots, values)) for v, b in zip(angles, blocks, strict=True)]
    )
    assert np.abs(smooth - whole).max() < 0.03, "of all samples"
    late = rows.raw(
        [np.interp(b.smooth(v), knots, values) for v, b in zip(angles, blocks, strict=True)]
    )
    assert np.abs(late - smooth).max() > 0.1


def test_score_is_that_of_each_kind_by_itself(tmp_path: Path) -> None:
    """Products are made once for the columns of all kinds."""
    bench = bench_of(tmp_path, lambda theta, rate, acceleration: 0.1 * np.sin(20 * theta))
    hypotheses = Hypotheses(bench, Rows.of(bench.model))
    for kind in hypotheses.generic(0):
        alone = replace(kind, within=kind.columns, place=slice(None))
        among, apart = (generic_score(hypotheses.moments, [own]) for own in (kind, alone))
        assert among.whole > 1.0
        assert among.by_fold == pytest.approx(apart.by_fold, rel=1e-6, abs=1e-6)
        assert among.size == pytest.approx(apart.size, rel=1e-6)
