"""The controller of the gateway, closed with the plant in one process, against the simulation."""

from __future__ import annotations

import math
import re
import subprocess
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from flexhex.ssp.executor import run
from flexhex.ssp.results import Result
from tests.gateway.archives import Spoil, member, spoiled
from tests.gateway.cargo import built, cargo
from tests.sampling import draw

SECONDS = 10.0
PATIENCE_S = 3.0
"""Longest wait for a step that is late or slow on purpose: no other takes as long."""
NEVER = 1e6
# A drive with current steps of 1 mA and a position of 2^32 counts a revolution.
STEPS = {
    "plant.tau_step": 0.003,
    "feedback.tau_step": 0.003,
    "plant.theta_step": 2 * math.pi / 2**32,
}
Rows = npt.NDArray[np.float64]


def closed_loop(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Runs the example program."""
    program = built() / "examples" / "closed_loop"
    words = [str(program), *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, timeout=300)


def rows(out: Path, signals: list[str], *arguments: object) -> dict[str, Rows]:
    """theta and tau_meas at n, tau that is commanded at n + 1, signals at n + 1; n = 0, 1, ..."""
    chosen = [word for signal in signals for word in ("--signal", signal)]
    done = closed_loop(*arguments, *chosen, "--out", out)
    assert done.returncode == 0, done.stderr
    table = np.fromfile(out).reshape(-1, 18 + len(signals))
    split = {"theta": table[:, :6], "tau_meas": table[:, 6:12], "tau": table[:, 12:18]}
    return split | {s: table[:, 18 + k] for k, s in enumerate(signals)}


def same(ours: Rows, theirs: Rows) -> bool:
    """Equal to the last bit."""
    bits = [np.ascontiguousarray(values).view(np.uint64) for values in (ours, theirs)]
    return ours.shape == theirs.shape and bool(np.array_equal(*bits))


@pytest.fixture(scope="module")
def simulated(hexapod_ssp: Path) -> Result:
    """The simulation, with the drive's quantisation."""
    signals = ["plant.theta", "plant.tau_meas", "feedback.tau", "feedback.e", "K.p", "N_E.x"]
    return run(hexapod_ssp, SECONDS, signals=signals, parameters=STEPS)


@pytest.mark.parametrize(
    "own",
    [[], ["K"], pytest.param(["K", "N_E"], marks=pytest.mark.slow)],
    ids=["inside", "K", "K and N_E"],
)
def test_controller_and_plant_give_the_simulation_to_the_last_bit(
    own: list[str], hexapod_ssp: Path, simulated: Result, tmp_path: Path
) -> None:
    p = simulated.group("K.p").columns("K.p")
    signals = [*(f"feedback.e[{k}]" for k in range(1, 7)), "N_E.x.lam_E[4]", *p]
    threads = [word for name in own for word in ("--own-thread", name)]
    steps = [word for name, value in STEPS.items() for word in ("--set", f"{name}={value!r}")]
    ours = rows(tmp_path / "rows", signals, hexapod_ssp, "--seconds", SECONDS, *threads, *steps)
    n = len(ours["theta"])
    assert n == round(SECONDS / 0.00025)
    assert same(ours["theta"], simulated["plant.theta"][:n])
    assert same(ours["tau_meas"], simulated["plant.tau_meas"][:n])
    assert same(ours["tau"], simulated["feedback.tau"][1 : n + 1])
    e = np.column_stack([ours[f"feedback.e[{k}]"] for k in range(1, 7)])
    assert same(e, simulated["feedback.e"][1 : n + 1])
    p_hat = np.column_stack([ours[name] for name in p])
    assert same(p_hat, np.repeat(simulated["K.p"], 120, axis=0)[1 : n + 1])
    assert same(ours["N_E.x.lam_E[4]"], np.repeat(simulated["N_E.x.lam_E[4]"], 2)[1 : n + 1])
    # the comparison is not of things that stand still
    assert np.ptp(ours["theta"], axis=0).min() > 0.1
    assert np.ptp(p_hat, axis=0).max() > 0.0


def test_the_comparison_tells_one_bit() -> None:
    a = np.linspace(1.0, 2.0, 6).reshape(2, 3)
    b = a.copy()
    b[1, 2] = np.nextafter(b[1, 2], 3.0)
    assert same(a, a.copy())
    assert not same(a, b)
    assert not same(a, b[:1])


def test_another_fmu_stands_in_for_the_plant(
    hexapod_ssp: Path, machine_ssp: Path, tmp_path: Path
) -> None:
    # out/machine/hexapod.ssp is the same system with machine.fmu for the plant
    fmu = tmp_path / "machine.fmu"
    fmu.write_bytes(member(machine_ssp.read_bytes(), "resources/machine.fmu"))
    simulated = run(machine_ssp, 1.0, signals=["plant.theta"])["plant.theta"]
    ours = rows(tmp_path / "rows", [], hexapod_ssp, "--seconds", 1, "--plant", fmu)
    nominal = rows(tmp_path / "rows", [], hexapod_ssp, "--seconds", 1)
    assert same(ours["theta"], simulated[: len(ours["theta"])])
    assert not same(ours["theta"], nominal["theta"])


def tripped(*arguments: object) -> tuple[str, int, str]:
    """Kind of a trip, base step and message."""
    done = closed_loop(*arguments)
    match = re.fullmatch(r"trip (\w+)(?:\(.*\))? at (\d+): (.*)\n", done.stderr)
    assert done.returncode == 3, done.stderr
    assert match, done.stderr
    return match[1], int(match[2]), match[3]


@pytest.mark.parametrize("own", [(), ("--own-thread", "K")], ids=["inside", "thread"])
@pytest.mark.parametrize(
    ("spoil", "kind", "now", "said"),
    [
        # feedback steps every base step: what step 40 gives is shown at 41
        (
            Spoil("feedback", 40, "set", "tau[3]", math.nan),
            "NotFinite",
            41,
            "feedback.tau[3] = NaN",
        ),
        (Spoil("feedback", 40, "error"), "Error", 40, "feedback: fmi2DoStep"),
        # 2 base steps a period, and only N_E of the two instances
        (
            Spoil("N_E", 25, "set", "x.arm[1].lam_Q[1]", math.inf),
            "NotFinite",
            52,
            "N_E.x.arm[1].lam_Q[1] = inf",
        ),
        (Spoil("F", 25, "set", "fault", 2.0), "Fault", 52, "F.fault = 2 (not_finite) "),
    ],
    ids=["nan", "error", "inf", "fault"],
)
def test_trouble_in_an_fmu_trips_at_its_base_step(
    spoil: Spoil,
    kind: str,
    now: int,
    said: str,
    own: tuple[str, ...],
    hexapod_ssp: Path,
    tmp_path: Path,
) -> None:
    package = spoiled(hexapod_ssp, spoil, tmp_path / "spoiled.ssp")
    trip = tripped(package, "--seconds", 0.1, "--fault-trips", *own)
    assert trip[:2] == (kind, now)
    assert said in trip[2]


@pytest.mark.parametrize(
    ("spoil", "own", "now"),
    [
        # 120 base steps a period: what step 3 gives is shown at 480, in its thread or not
        (Spoil("K", 3, "set", "p.actuator[1].a[1]", math.nan), (), 480),
        (Spoil("K", 3, "set", "p.actuator[1].a[1]", math.nan), ("--own-thread", "K"), 480),
        (Spoil("K", 3, "error"), (), 360),
        # the error of a thread is heard when its result is due
        (Spoil("K", 3, "error"), ("--own-thread", "K"), 480),
    ],
    ids=["nan", "nan-thread", "error", "error-thread"],
)
def test_trouble_in_the_estimator_trips_when_its_result_is_due(
    spoil: Spoil, own: tuple[str, ...], now: int, hexapod_ssp: Path, tmp_path: Path
) -> None:
    package = spoiled(hexapod_ssp, spoil, tmp_path / "spoiled.ssp")
    kind, at, text = tripped(package, "--seconds", 0.2, *own)
    assert (kind, at) == ("NotFinite" if spoil.kind == "set" else "Error", now)
    assert text.startswith("K")


def test_a_late_estimator_trips_when_its_result_is_due(hexapod_ssp: Path, tmp_path: Path) -> None:
    package = spoiled(hexapod_ssp, Spoil("K", 3, "sleep", value=NEVER), tmp_path / "late.ssp")
    trip = tripped(package, "--seconds", 0.2, "--own-thread", "K", "--wait", PATIENCE_S)
    assert trip[:2] == ("Late", 480)
    assert "K: fed at base step 360, not finished at 480" in trip[2]


def test_lockstep_waits_for_a_late_estimator(hexapod_ssp: Path, tmp_path: Path) -> None:
    spoil = Spoil("K", 3, "sleep", value=0.5)
    package = spoiled(hexapod_ssp, spoil, tmp_path / "late.ssp")
    signals = ["K.p.actuator[1].a[6]", "K.innovation[1]"]
    late = rows(tmp_path / "a", signals, package, "--seconds", 0.3, "--own-thread", "K")
    plain = rows(tmp_path / "b", signals, hexapod_ssp, "--seconds", 0.3)
    assert all(same(late[name], plain[name]) for name in plain)


def test_held_late_ticks_are_left_out_and_counted(hexapod_ssp: Path, tmp_path: Path) -> None:
    spoil = Spoil("K", 3, "sleep", value=NEVER, count=1)
    package = spoiled(hexapod_ssp, spoil, tmp_path / "late.ssp")
    own = ("--own-thread", "K", "--hold", "--wait", PATIENCE_S)
    done = closed_loop(package, "--seconds", 0.16, *own)
    # fed at 360, due at 480, 600: never done
    assert done.returncode == 0, done.stderr
    assert "late 2 " in done.stdout


def test_a_slow_step_trips(hexapod_ssp: Path, tmp_path: Path) -> None:
    spoil = Spoil("feedback", 40, "sleep", value=PATIENCE_S + 0.5)
    package = spoiled(hexapod_ssp, spoil, tmp_path / "slow.ssp")
    kind, now, text = tripped(package, "--seconds", 0.1, "--step-limit", PATIENCE_S)
    assert (kind, now) == ("Overrun", 40)
    assert text.startswith("feedback: its step at base step 40 took")


def test_rust_tests_of_all_crates_pass(hexapod_ssp: Path) -> None:
    """Faults drawn at random (gateway/src/cycle/tests/property.rs) and spoiled replies
    (bring_up.rs there): those of the day."""
    faults = ",".join(str(k) for k in draw(range(40), 2, "faults of the gateway"))
    spoiled = draw(range(1_000_000), 1, "spoiled replies")[0]
    more = {"FLEXHEX_SSP": str(hexapod_ssp.resolve()), "FLEXHEX_FAULTS": faults}
    more["FLEXHEX_DRAW"] = str(spoiled)
    done = cargo("test", "--workspace", **more)
    assert done.returncode == 0, done.stdout + done.stderr
