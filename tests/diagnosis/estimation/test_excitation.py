"""The motion that `identify --next` writes: within what was shown, and worth what it promises."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.excitation import Excitation, excitation
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.result.estimates import Parameter
from tests.diagnosis.estimation import machines

Array = NDArray[np.float64]
T = np.arange(5000) * machines.TS


def logged(folder: Path, name: str, q: Array) -> Path:
    """A run of the cart along a motion (samples, 3)."""
    v, a = np.gradient(q, machines.TS, axis=0), np.zeros_like(q)
    a[1:-1] = np.diff(q, 2, axis=0) / machines.TS**2
    tau = machines.inverse(machines.heavier(machines.CART), q, v, a)
    tau += machines.rubbed(v, machines.DRY, machines.VISCOUS) + machines.OFFSETS
    head, slides = f"# trajectory: {name}\n", (True, False, False)
    return machines.write(folder / f"{name}.csv", T[: len(q)], q, tau, slides, head, 1)


def timid() -> Array:
    """The two hinges move nearly together, the wrist alone hardly."""
    q, _, _ = machines.moved(T, 1, (0.25, 0.7, 0.8))
    q[:, 2] = 0.9 * q[:, 1] + 0.05 * q[:, 2]
    return q


@pytest.fixture(scope="module")
def before(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Identified, Excitation]:
    folder = tmp_path_factory.mktemp("timid")
    (folder / "cart.xml").write_text(machines.CART)
    log = logged(folder, "timid", timid())
    identified = identify([log], options=Options(str(folder / "cart.xml")))
    return folder, identified, excitation(identified)


def wide(one: Parameter) -> float:
    low, high = one.estimate.ci95
    return high - low


def test_motion_stays_within_what_the_log_has_shown(
    before: tuple[Path, Identified, Excitation],
) -> None:
    r, q = before[2].motion.r, timid()
    assert (r.min(axis=0) >= q.min(axis=0)).all()
    assert (r.max(axis=0) <= q.max(axis=0)).all()
    for order in (1, 2):
        ours, theirs = (np.abs(np.diff(x, order, axis=0)).max(axis=0) for x in (r, q))
        # speeds and accelerations of the log are means over 20 ms
        assert (ours <= 1.02 * theirs).all(), order
    assert np.ptp(r[:500], axis=0).max() == 0
    assert np.array_equal(r[0], r[-1])


def test_a_run_along_it_narrows_as_much_as_was_promised(
    before: tuple[Path, Identified, Excitation],
) -> None:
    folder, _, more = before
    every = more.motion.r[:: max(1, round(machines.TS / more.motion.ts))]
    new = logged(folder, "next", every[1000 : 1000 + len(T)])
    again = identify([folder / "timid.csv", new], options=Options(str(folder / "cart.xml")))
    names = {one.name: one for one in (*again.parameters, *again.combinations)}
    ratios = {
        one.name: (wide(names[one.name]) / wide(one), promised)
        for one, promised in more.narrowed
        if one.name in names
    }
    # three intervals in four shrink by what was said, within a factor of two
    off = [abs(np.log(real / promised)) for real, promised in ratios.values()]
    assert np.quantile(off, 0.75) < np.log(2), ratios
    # more than a second run along the old motion would: that divides them by the root of two
    assert np.exp(np.mean([np.log(real) for real, _ in ratios.values()])) < 0.9 / np.sqrt(2)
    assert min(promised for _, promised in more.narrowed) < 0.3
