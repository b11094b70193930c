"""A payload that no log announces is found on the runs that carry it, and on no others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from tests.compare import assert_close
from tests.diagnosis.estimation import machines

Array = NDArray[np.float64]
HEAVY = machines.CART.replace('density="2000"', 'density="6000"')
"""The cart with three times the gripper."""


def carts(folder: Path, loaded: tuple[int, ...], seeds: tuple[int, ...]) -> Identified:
    """The cart identified from its runs, of which some carry more."""
    file = folder / "cart.xml"
    file.write_text(machines.CART)
    paths = [
        machines.cart_runs(folder, machines.heavier(HEAVY if s in loaded else machines.CART), (s,))[
            0
        ]
        for s in seeds
    ]
    return identify(paths, options=Options(str(file)))


@pytest.mark.sample(1)
@pytest.mark.parametrize("loaded", [(3,), (2, 3), (1, 2, 3)])
def test_the_runs_that_carry_it_are_named_with_its_mass(
    tmp_path: Path, loaded: tuple[int, ...]
) -> None:
    identified = carts(tmp_path, loaded, (1, 2, 3, 4))
    more = machines.heavier(HEAVY).body_mass.sum() - machines.heavier(machines.CART).body_mass.sum()
    low, high = identified["payload.m"].estimate.ci95
    assert low <= more <= high
    assert high - low < 0.1 * more
    names = ", ".join(f"cart-{seed}.csv" for seed in loaded)
    verb = "carries" if len(loaded) == 1 else "carry"
    assert identified.notes[0].startswith(f"{names}: {verb} ")
    # the machine is the one without it
    assert (identified.errors.fitted < 0.004).all()
    low, high = identified["F_c[1]"].estimate.ci95
    assert low <= machines.DRY[0] <= high


def test_nothing_is_named_where_all_carry_the_same(tmp_path: Path) -> None:
    for loaded in ((), (1, 2, 3)):
        identified = carts(tmp_path, loaded, (1, 2, 3))
        assert "payload.m" not in {one.name for one in identified.parameters}
        assert not any("announces" in note for note in identified.notes)


def test_another_friction_on_one_run_is_no_payload(tmp_path: Path) -> None:
    """A warm gear leaves much of that run's torque, none of it as a mass does."""
    file, t = tmp_path / "cart.xml", np.arange(5000) * machines.TS
    file.write_text(machines.CART)
    model, paths = machines.heavier(machines.CART), []
    for seed, factor in ((1, 1.0), (2, 1.0), (3, 1.6)):
        q, v, a = machines.moved(t, seed, (0.25, 0.7, 0.8))
        dry = tuple(factor * size for size in machines.DRY)
        tau = machines.inverse(model, q, v, a) + machines.rubbed(v, dry, machines.VISCOUS)
        path = tmp_path / f"{seed}.csv"
        slides = (True, False, False)
        paths.append(machines.write(path, t, q, tau, slides, f"# trajectory: {seed}\n", seed))
    identified = identify(paths, options=Options(str(file)))
    assert not any("announces" in note for note in identified.notes)


def loaded_axis(folder: Path, more: Callable[[Array], Array]) -> Identified:
    """An axis along three motions, with half as much again on the last; more: what it lacks."""
    t, paths = np.arange(5000) * machines.TS, []
    for seed, inertia in ((1, 0.4), (2, 0.4), (3, 0.6)):
        q, v, a = machines.moved(t, seed, (0.8,))
        tau = inertia * a + 3.0 * inertia * np.cos(q) + machines.rubbed(v, (0.2,), (0.1,))
        path, head = folder / f"{seed}.csv", f"# trajectory: {seed}\n"
        paths.append(machines.write(path, t, q, tau + more(q), (False,), head, seed))
    return identify(paths, options=Options("axis"))


def test_an_axis_that_carries_more_is_named_by_its_inertia(tmp_path: Path) -> None:
    identified = loaded_axis(tmp_path, np.zeros_like)
    low, high = identified["payload.J[1]"].estimate.ci95
    assert low <= 0.2 <= high
    assert high - low < 0.01
    assert identified.notes[0].startswith("3.csv: carries 0.2")
    assert_close(identified["J[1]"].estimate.value, 0.4, rtol=1e-3)


def test_a_model_that_lacks_a_fifth_of_the_torque_shows_no_payload(tmp_path: Path) -> None:
    """A torque of the place that no term has bends whatever is fitted."""
    identified = loaded_axis(tmp_path, lambda q: np.asarray(4.0 * np.sin(15.0 * q)))
    assert identified.errors.fitted[0] > 0.2
    assert not any(one.name.startswith("payload") for one in identified.parameters)
    assert not any("announces" in note for note in identified.notes)
