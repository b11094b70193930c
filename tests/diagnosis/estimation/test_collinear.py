"""Terms that the motions do not tell apart are left out, or given as the sum that they are."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from flexhex.identify.other import print_identified, short
from tests.compare import assert_close
from tests.diagnosis.estimation import machines

Array = NDArray[np.float64]
TERMS = ("o[1]", "k[1]", "g_s[1]", "g_c[1]")


def axis(folder: Path, size: float, of_angle: Callable[[Array], Array]) -> Identified:
    """An axis that swings by size [rad] about 0.6 rad, with a torque that its angle makes."""
    t, paths = np.arange(5000) * machines.TS, []
    for seed in (1, 2, 3):
        q, v, a = machines.moved(t, seed, (size,))
        q = q + 0.6
        tau = 0.4 * a + of_angle(q) + machines.rubbed(v, (0.2,), (0.1,))
        head = f"# trajectory: {seed}\n"
        path = folder / f"{seed}.csv"
        paths.append(machines.write(path, t, q, tau, (False,), head, seed))
    return identify(paths[:2], paths[2:], options=Options("axis"))


def test_terms_that_nothing_is_lost_without_stand_in_sums(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A spring and a weight on a short stroke are one slope and one offset."""
    identified = axis(tmp_path, 0.1, lambda q: np.asarray(2.0 * np.cos(q) + 0.5 * q - 0.3))
    true = {"o[1]": -0.3, "k[1]": 0.5, "g_s[1]": 0.0, "g_c[1]": 2.0}
    sums = [one for one in identified.combinations if len(one.terms) > 1]
    assert sums
    for one in sums:
        low, high = one.estimate.ci95
        # a sum is that of the textbook where the others' curvature is nothing: 1 % of its terms
        bend = 0.01 * sum(abs(factor * true[name]) for name, factor in one.terms)
        wanted = sum(factor * true[name] for name, factor in one.terms)
        assert low - bend <= wanted <= high + bend, one.name
        assert high - low < 0.5, "none that cancels in hundreds"
        for name, _ in one.terms:
            assert math.isinf(identified[name].estimate.ci95[1]), name
            assert not identified[name].determined, name
    assert any("sums alone have values" in note for note in identified.notes)
    print_identified(identified)
    shown = capsys.readouterr().out
    assert all(short(one.terms) in shown for one in sums if one.determined)
    assert any(one.determined for one in sums)
    # what is left out is no value of a file
    assert "exact" not in shown
    assert identified.held_out is not None
    assert identified.held_out.fitted[0] < 0.02
    # 0.1 %: some four standard deviations
    assert_close(identified["J[1]"].estimate.value, 0.4, rtol=1e-3)


def test_terms_that_are_needed_but_cancel_are_given_as_their_sum(tmp_path: Path) -> None:
    """A torque of its own form takes all of them, and tells of none by itself."""

    def bend(q: Array) -> Array:
        return np.asarray(3.0 * np.cos(9.0 * (q - 0.6)))

    identified = axis(tmp_path, 0.25, bend)
    (together,) = [one for one in identified.combinations if len(one.terms) > 1]
    names = [name for name, _ in together.terms]
    assert set(names) <= set(TERMS)
    assert math.isinf(identified[names[0]].estimate.ci95[1])
    assert not any(identified[name].determined for name in names)
    low, high = together.estimate.ci95
    assert high - low < 1.0
    assert any("cancel each other on these motions" in note for note in identified.notes)


def test_terms_that_a_wide_motion_tells_apart_stay(tmp_path: Path) -> None:
    identified = axis(tmp_path, 0.8, lambda q: np.asarray(2.0 * np.cos(q) + 0.5 * q))
    for name, true in (("k[1]", 0.5), ("g_c[1]", 2.0), ("g_s[1]", 0.0), ("o[1]", 0.0)):
        low, high = identified[name].estimate.ci95
        assert low <= true <= high, name
        assert identified[name].determined, name
    assert not any("sums alone" in note or "cancel" in note for note in identified.notes)
