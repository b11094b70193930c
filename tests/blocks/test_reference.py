"""The reference: equal to its twin, of one instant, repeatable, within its limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.blocks import reference_twin as twin
from tests.blocks.loaded import Loaded, StartError, load
from tests.compare import assert_close

Array = twin.Array
TS = 0.00025
RANDOM, TRIANGLE, MULTISINE, CHIRP, HOLD = range(5)


def started(**parameters: Any) -> Loaded:
    block = load("reference")
    block.start(**parameters)
    return block


def run(block: Loaded, ticks: int) -> dict[str, Array]:
    """Outputs as shown at times 2 Ts, 3 Ts, ... of the ticks at Ts, 2 Ts, ..."""
    rows: dict[str, list[Any]] = {name: [] for name in ("r", "rd", "rdd", "payload")}
    for _ in range(ticks):
        y = block.tick()
        for name, values in rows.items():
            values.append(y[name])
    return {name: np.array(values) for name, values in rows.items()}


def one_pass(duration: float, t_start: float = 0.1, **parameters: Any) -> tuple[Array, list[Array]]:
    """Times since the begin of the pass [s], and r, rd, rdd from there to its end."""
    block = started(duration=duration, t_start=t_start, passes=1, **parameters)
    y = run(block, round((t_start + duration) / TS))
    first = round(t_start / TS) - 2
    t = np.asarray(TS * np.arange(len(y["r"]) - first), dtype=np.float64)
    return t, [y[name][first:] for name in ("r", "rd", "rdd")]


def test_twin_draws_the_published_numbers() -> None:
    """Numbers from Rosetta Code, "Pseudo-random numbers/Splitmix64"."""
    assert twin.splitmix64(1234567, 5) == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


@pytest.mark.parametrize("seed", [0, 1, 1234567, 2**53])
def test_reference_setpoints_are_the_twins_to_the_last_bit(seed: int) -> None:
    t, (r, _, _) = one_pass(1.0, seed=seed, period=0.01, move=0.005, amplitude=0.3)
    points = twin.setpoints(seed, 0.3, moves=100)
    at = np.searchsorted(t, np.arange(1, 101) * 0.01 - TS)
    assert np.array_equal(r[at], points[1:])
    assert 0.28 < np.abs(points).max() <= 0.3


def test_reference_random_motion_equals_its_twin() -> None:
    t, actual = one_pass(5.0, seed=3, amplitude=0.19)
    expected = twin.random_motion(t, twin.setpoints(3, 0.19, moves=5), 1.0, 0.6)
    # rounding of the angle, over move and move^2
    for name, a, e, atol in zip(
        ["r", "rd", "rdd"], actual, expected, (1e-15, 1e-14, 2e-13), strict=True
    ):
        assert_close(a[: len(t) - 1], e[: len(t) - 1], atol=atol, what=name)


def test_reference_acceleration_is_piecewise_linear_and_continuous() -> None:
    _, (r, rd, rdd) = one_pass(2.0, amplitude=0.19, move=0.6)
    jerk = np.diff(rdd, axis=0) / TS
    distance = r[-1] - r[0] if np.any(r[-1]) else r[4000 - 1] - r[0]
    # 0.6 s is 2400 ticks: the quarters of a move are whole numbers of ticks
    assert_close(np.abs(jerk[:2399]), np.tile(np.abs(32 * distance / 0.6**3), (2399, 1)), atol=1e-7)
    assert np.abs(np.diff(rdd, axis=0)).max() <= 1.01 * np.abs(jerk).max() * TS
    assert not rd[2400:4000].any()
    assert not rdd[2400:4000].any()


@pytest.mark.parametrize("kind", [RANDOM, TRIANGLE, MULTISINE, CHIRP])
def test_reference_rates_are_the_derivatives(kind: int) -> None:
    _, (r, rd, rdd) = one_pass(4.0, kind=kind, speed=0.5, rounding=10.0, seed=5)
    # central differences over 0.5 ms; the acceleration of the triangle jumps by 10 rad/s2
    jumps = 11 * TS if kind == TRIANGLE else 0.0
    assert_close(rd[1:-1], (r[2:] - r[:-2]) / (2 * TS), atol=1e-5 + jumps, what="rd")
    corners = np.abs(rdd[2:] - rdd[:-2]) > 5 if kind == TRIANGLE else np.zeros(rdd[1:-1].shape)
    difference = np.where(corners, rdd[1:-1], (rd[2:] - rd[:-2]) / (2 * TS))
    # where the jerk changes its sign the difference is off by jerk Ts / 2: 60 rad/s3 here
    assert_close(rdd[1:-1], difference, atol=8e-3, what="rdd")
    assert np.abs(rdd).max() > 1


def test_reference_passes_are_the_same_to_the_last_bit() -> None:
    for kind in (RANDOM, TRIANGLE, MULTISINE, CHIRP):
        block = started(kind=kind, duration=3, passes=3, t_start=0.5, speed=0.6, rounding=20)
        y = run(block, round(10.5 / TS))
        first, length = round(0.5 / TS) - 2, round(3 / TS)
        passes = [y["r"][first + k * length :][:length] for k in range(4)]
        assert np.array_equal(passes[0], passes[1])
        assert np.array_equal(passes[0], passes[2])
        assert np.abs(passes[0]).max() > 0.05
        assert not passes[0][0].any()
        assert np.abs(passes[0][-1]).max() < 1e-6, "a pass returns to zero"
        assert not passes[3].any(), "afterwards it rests"


def test_reference_shows_the_instant_of_its_time_and_zero_before() -> None:
    block = started(t_start=0.01, seed=1, amplitude=0.19, period=0.1, move=0.1, duration=1)
    assert not any(load("reference").start()[name].any() for name in ("r", "rd", "rdd"))
    y = run(block, 100)
    begin = round(0.01 / TS)
    rdd = y["rdd"][:, 0]
    # row k is shown at (k + 2) Ts; one tick after the begin the acceleration is one tick's jerk
    assert not rdd[: begin - 1].any()
    jerk = 32 * twin.setpoints(1, 0.19, 10)[1, 0] / 0.1**3
    assert_close(rdd[begin - 1], jerk * TS, rtol=1e-12)


@pytest.mark.parametrize("kind", [RANDOM, TRIANGLE, MULTISINE, CHIRP, HOLD])
def test_reference_rests_until_its_start(kind: int) -> None:
    y = run(started(kind=kind, t_start=0.1, speed=0.5, rounding=10.0), 398)
    # the last row is shown at 399 Ts, one before the start
    assert not any(y[name].any() for name in ("r", "rd", "rdd"))


@pytest.mark.parametrize("kind", [RANDOM, TRIANGLE, MULTISINE, CHIRP])
def test_reference_is_the_same_after_days(kind: int) -> None:
    """Ticks are counted, no time is added up: a month later every bit is as in the first pass."""
    length, skipped = round(3 / TS), 900_000
    given = {"duration": 3, "passes": 1e6, "t_start": 0.5, "speed": 0.6, "rounding": 20}
    blocks = [started(kind=kind, **given) for _ in range(2)]
    blocks[1].state[0] += skipped * length  # its only changing number: the count of ticks
    early, late = (run(block, 6000) for block in blocks)
    assert all(np.array_equal(early[name][2000:], late[name][2000:]) for name in early)
    assert early["r"].any()


def test_reference_triangle_equals_its_twin() -> None:
    amplitude = np.array([0.1, 0.2, 0.0, 0.05, 0.3, 0.07])
    t, actual = one_pass(9.0, kind=TRIANGLE, amplitude=amplitude, speed=0.3, rounding=2.0)
    for i, size in enumerate(amplitude):
        cycle, extra = 4 * size / 0.3 + 2 * 0.3 / 2, 0.3 / 2
        cycles = int((9 - extra) // cycle)
        expected = (
            twin.triangle_motion(t, cycles, size, 0.3, 2.0) if size else np.zeros((3, len(t)))
        )
        # at a corner rounding may put a tick before or after the jump of the acceleration
        same = np.abs(actual[2][:, i] - expected[2]) < 1e-9
        assert np.mean(same) > 0.998
        for a, e in zip(actual[:2], expected[:2], strict=True):
            assert_close(a[:-1, i], e[:-1], atol=1e-12, what=f"joint {i + 1}")
        assert_close(np.abs(actual[0][:, i]).max(), size, atol=1e-6)
        assert size == 0 or cycles >= 1


def test_reference_multisine_equals_its_twin() -> None:
    t, (r, _, _) = one_pass(6.0, kind=MULTISINE, seed=9, f_base=0.5, n_sines=4, amplitude=0.2)
    drawn = np.array([(x >> 11) / 2**53 for x in twin.splitmix64(9, 96)]).reshape(6, 16)
    waves = [np.sin(2 * np.pi * (0.5 * k * t[:, None] + drawn[:, k - 1])) for k in range(1, 5)]
    assert_close(r, twin.faded(t, 6.0, 1.0, 0.2 * np.mean(waves, axis=0)), atol=1e-14)
    assert 0.1 < np.abs(r).max() <= 0.2


def test_reference_chirp_equals_its_twin() -> None:
    t, (r, _, _) = one_pass(6.0, kind=CHIRP, f0=0.5, f1=4.0, amplitude=np.linspace(0, 0.1, 6))
    wave = np.sin(2 * np.pi * (0.5 * t + 3.5 / 12 * t**2))[:, None] * np.linspace(0, 0.1, 6)
    assert_close(r, twin.faded(t, 6.0, 1.0, wave), atol=1e-14)


def test_reference_holds() -> None:
    y = run(started(kind=HOLD), 9000)
    assert not y["r"].any()


def test_reference_payload_follows_its_schedule() -> None:
    times, masses = [0.0, 0.002, 0.004, *5 * [0.0]], [0.3, 1.5, 0.0, *5 * [9.0]]
    block = load("reference")
    first = block.start(payload_count=3, payload_time=times, payload_mass=masses)
    assert first["payload"] == 0.3
    payload = run(block, 20)["payload"]
    shown = (np.arange(20) + 2) * TS
    expected = np.select([shown > 0.00399, shown > 0.00199], [0.0, 1.5], 0.3)
    assert np.array_equal(payload, expected)


def test_reference_state_is_all_there_is() -> None:
    block = started(kind=MULTISINE, t_start=0.01)
    run(block, 200)
    kept = block.state.copy()
    first = run(block, 200)
    block.state[:] = kept
    assert np.array_equal(first["r"], run(block, 200)["r"])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"kind": 0.5}, "kind = 0.5, must be a whole number"),
        ({"seed": 1.5}, "seed = 1.5, must be a whole number"),
        ({"passes": 1.5}, "passes = 1.5, must be a whole number"),
        ({"n_sines": 1.5}, "n_sines = 1.5, must be a whole number"),
        ({"payload_count": 1.5}, "payload_count = 1.5, must be a whole number"),
        ({"t_start": 0.0001}, "t_start = 0.0001 s, must be a whole number of Ts = 0.00025 s"),
        ({"duration": 1.5}, "duration = 1.5 s, must be a whole number of period = 1 s"),
        ({"period": 1.0001, "duration": 10.001}, "period = 1.0001 s, must be a whole number of Ts"),
        ({"move": 1.2}, "move = 1.2 s, longer than period = 1 s: shorten the move"),
        ({"kind": TRIANGLE, "speed": 1.0}, "amplitude[1] = 0.233 rad, the corners of the triangle"),
        ({"kind": TRIANGLE, "duration": 2}, "duration = 2 s, too short for one cycle"),
        ({"kind": CHIRP, "fade": 26}, "fade = 26 s, longer than half of duration = 50 s"),
        ({"kind": MULTISINE, "fade": 26}, "fade = 26 s, longer than half of duration = 50 s"),
        ({"payload_count": 2}, "payload_time[2] = 0 s, must be later than the 0 s before it"),
    ],
)
def test_reference_refuses_what_cannot_be(parameters: dict[str, float], message: str) -> None:
    with pytest.raises(StartError) as error:
        load("reference").start(**parameters)
    assert str(error.value).startswith(message)
