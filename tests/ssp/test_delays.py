"""Delays by walking the schedule against stamps carried step by step, in Python and in FMUs."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace

import pytest

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface
from flexhex.ssp.delays import alignment, path_delay, reference_delay
from flexhex.ssp.executor import run
from flexhex.ssp.hexapod import TORQUE_PATH, hexapod
from tests.ssp.test_system import blocks
from tests.ssp.toys import chain, pack

DRIVE = SimpleNamespace(f_current=1000.0, t_command=0.0, t_measurement=0.0)


def simulated_ages(periods: list[int], last_steps: int = 4000) -> list[int]:
    """Ages of the samples of the last of a chain, by integers handed on at every base step.

    Written from the timing rule alone, forwards, unlike ssp.delays which walks backwards.
    """
    shown: list[int | None] = [None] * len(periods)
    pending: list[int | None] = [None] * len(periods)
    ages = []
    for n in range(last_steps):
        if n % periods[0] == 0:
            shown[0] = n
        for k in range(1, len(periods)):
            if n % periods[k] == 0:
                shown[k] = pending[k]
        for k in range(1, len(periods)):
            if n >= 1 and n % periods[k] == 0:
                pending[k] = shown[k - 1]
        seen = pending[-1]
        if n % periods[-1] == 0 and n > last_steps // 2 and seen is not None:
            ages.append(n - seen)
    return ages


@pytest.mark.parametrize(
    "periods",
    [[1, 2, 2, 1, 1], [2, 2, 120], [2, 120], [1, 1], [3, 2, 5, 1], [1, 6, 4, 3], [4, 1, 1]],
)
def test_path_delay_equals_integer_simulation(periods: list[int]) -> None:
    system = chain(*periods)
    delay = path_delay(system, [f"c{k}" for k in range(1, len(periods) + 1)])
    assert set(delay.ages) == set(simulated_ages(periods))


@pytest.mark.parametrize("periods", [(2, 2, 1, 1), (2, 2, 120), (3, 2, 5), (120,)])
def test_stamps_through_fmus_have_the_declared_age(
    periods: tuple[int, ...], work: Path, cache: Path
) -> None:
    system = chain(*periods)
    ssp = pack(system, work / "chains")
    last, period = f"c{len(periods)}", periods[-1]
    rows = run(ssp, 0.5, cache=cache)[f"{last}.y"][:, 0]
    # row k is seen at k period and was sampled one period before
    ages = {int((k - 1) * period - stamp) for k, stamp in enumerate(rows) if k * period > 800}
    delay = path_delay(system, [c.name for c in system.components])
    assert ages == set(delay.ages)


def test_reference_delay_is_the_papers_z6_plus_the_drive() -> None:
    system = hexapod(blocks())
    delay = path_delay(system, TORQUE_PATH)
    assert (delay.shortest, delay.longest, delay.mean) == (5, 6, 6.0)
    fast = SimpleNamespace(f_current=math.inf, t_command=0.0, t_measurement=0.0)
    assert reference_delay(system, fast) == 6.0
    # 1 kHz current loop: 1 / (2 pi 1000 Hz) = 0.159 ms = 0.6366 base steps
    assert reference_delay(system, DRIVE) == pytest.approx(6.6366, abs=1e-4)
    late = SimpleNamespace(f_current=math.inf, t_command=0.00025, t_measurement=0.0005)
    assert reference_delay(system, late) == pytest.approx(9.0, abs=1e-12)


def test_alignment_is_the_one_sample_that_kinematics_adds() -> None:
    system = hexapod(blocks())
    assert path_delay(system, ("W", "N_E", "K")).sampled == 2
    assert path_delay(system, ("W", "K")).sampled == 0
    assert alignment(system) == 1


def test_delays_follow_the_sample_times() -> None:
    slow = blocks()
    for block in ("kinematics", "feedforward"):
        slow[block] = _with_Ts(slow[block], 0.001)
    system = hexapod(slow)
    assert path_delay(system, TORQUE_PATH).mean == 4 + 4 + 1 + 4 / 2
    assert alignment(system) == 2


def test_alignment_that_differs_from_tick_to_tick_is_refused() -> None:
    odd = blocks()
    odd["estimator"] = _with_Ts(odd["estimator"], 121 * 0.00025)
    with pytest.raises(InterfaceError, match="divide one another"):
        alignment(hexapod(odd))


def test_age_that_varies_has_no_single_value() -> None:
    with pytest.raises(InterfaceError, match="varies between"):
        _ = path_delay(chain(3, 2, 1), ("c1", "c2", "c3")).sampled


@pytest.mark.parametrize(
    ("path", "text"),
    [(("c1",), "at least two"), (("c1", "c3"), "c1 feeds no c3"), (("c1", "c9"), "no component")],
)
def test_path_that_does_not_exist_is_refused(path: tuple[str, ...], text: str) -> None:
    with pytest.raises(InterfaceError, match=text):
        path_delay(chain(1, 2, 1), path)


def _with_Ts(interface: Interface, Ts: float) -> Interface:
    return dataclasses.replace(interface, Ts=Ts)
