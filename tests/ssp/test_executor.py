"""The multi-rate executor gives, bit for bit, what base-step masters give; errors are named."""

from __future__ import annotations

import os
import zipfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp

from flexhex.fmus.common.errors import InterfaceError, RunError, UsageError
from flexhex.ssp.executor import run
from flexhex.ssp.library import load
from flexhex.ssp.results import Result
from tests.ssp import toys

STEPS = {"src": 1, "a": 1, "a2": 1, "b": 2, "c": 120}


def fmpy_rows(path: Path, n_steps: int) -> Any:
    """FMPy's record of n_steps base steps.

    FMPy records after the step and under the time before it: row k holds what is seen at
    base step k + 1. Row j of a component with period N (seen at j N) is row j N - 1 there;
    the initial values (j = 0) FMPy does not record. It stops when its summed time reaches
    stop_time, so half a step less gives exactly n_steps rows.
    """
    base = 0.00025
    rows = simulate_ssp(str(path), stop_time=(n_steps - 0.5) * base, step_size=base)
    assert len(rows) == n_steps
    return rows


def test_executor_equals_fmpy_bit_for_bit(ring_ssp: Path, cache: Path) -> None:
    n_steps = 600
    result, rows = run(ring_ssp, n_steps * 0.00025, cache=cache), fmpy_rows(ring_ssp, n_steps)
    for name, period in STEPS.items():
        variable = "r" if name == "src" else "y"
        ours = result[f"{name}.{variable}"]
        for k in (1, 2):
            theirs = rows[f"{name}.{variable}[{k}]"][period - 1 :: period]
            assert ours[1:, k - 1].tobytes() == theirs.tobytes(), f"{name}.{variable}[{k}]"


def test_row_mapping_matters(ring_ssp: Path, cache: Path) -> None:
    # one row earlier FMPy still shows the previous value: the comparison sees the shift
    result, rows = run(ring_ssp, 0.05, cache=cache), fmpy_rows(ring_ssp, 200)
    assert result["b.y"][1:, 1].tobytes() == rows["b.y[2]"][1::2].tobytes()
    assert result["b.y"][1:, 1].tobytes() != rows["b.y[2]"][0::2].tobytes()


def test_executor_equals_python_jacobi_bit_for_bit(ring_ssp: Path, cache: Path) -> None:
    n_steps = 1200
    result = run(ring_ssp, n_steps * 0.00025, cache=cache)
    reference = toys.jacobi(toys.ring(), n_steps)
    for name, period in STEPS.items():
        ours = result[f"{name}.{'r' if name == 'src' else 'y'}"]
        expected = np.array(reference[name])[::period]
        assert ours.tobytes() == expected.tobytes(), name
        assert np.ptp(ours[:, 1]) > 0.1, f"{name} does not move: nothing was compared"


def test_duration_need_not_be_a_multiple_of_slow_periods(ring_ssp: Path, cache: Path) -> None:
    result, long = run(ring_ssp, 121 * 0.00025, cache=cache), run(ring_ssp, 0.1, cache=cache)
    for name, rows in (("a.y", 122), ("b.y", 61), ("c.y", 2)):
        assert len(result[name]) == rows
        assert result[name].tobytes() == long[name][:rows].tobytes()


def test_rates_stay_apart_and_time_counts_whole_steps(ring_ssp: Path, cache: Path) -> None:
    result = run(ring_ssp, 30.0, signals=["c.y", "b.y[2]", "src.fault"], cache=cache)
    assert list(result.groups) == ["0.25ms", "0.5ms", "30ms"]
    assert result["b.y[2]"].shape == (60001,)
    assert result["c.y"].shape == (1001, 2)
    # integer counts times the base step: no drift after 120 000 steps
    assert result.time("src.fault")[-1] == 120_000 * 0.00025
    assert result.groups["0.25ms"].units["src.fault"] == "1"
    with pytest.raises(Exception, match=r"no signal 'a\.y'"):
        _ = result["a.y"]


def test_default_leaves_large_arrays_out(ring_ssp: Path, cache: Path) -> None:
    from flexhex.ssp import signals

    all_ = run(ring_ssp, 0.001, cache=cache)
    assert {"src.r", "a.y", "c.fault"} <= set(_names(all_))
    large, signals.LARGE = signals.LARGE, {"y"}
    try:
        assert "a.y" not in _names(run(ring_ssp, 0.001, cache=cache))
        assert "a.y" in _names(run(ring_ssp, 0.001, signals=["default", "a.y"], cache=cache))
        assert "b.y" in _names(run(ring_ssp, 0.001, signals=["b"], cache=cache))
    finally:
        signals.LARGE = large


def test_first_warning_of_an_fmu_is_kept(ring_ssp: Path, cache: Path) -> None:
    quiet = run(ring_ssp, 0.01, cache=cache)
    assert {(t.warnings, t.warning) for t in quiet.times.values()} == {(0, "")}
    # the source reports fault 2 from its second tick on when the wave is beyond 100
    loud = run(ring_ssp, 0.01, parameters={"src.gain": 1e5}, cache=cache).times["src"]
    assert loud.warnings == 1
    assert loud.warning.startswith("fault = 2 (wide) from 0.0005 s on")


def test_parameters_overrule_the_file(ring_ssp: Path, cache: Path) -> None:
    plain = run(ring_ssp, 0.01, cache=cache)
    louder = run(ring_ssp, 0.01, parameters={"src.gain": 2.6}, cache=cache)
    assert np.array_equal(louder["src.r"][:, 1], 2 * plain["src.r"][:, 1])
    assert louder.meta["parameter src.gain"] == 2.6


def test_times_and_counts_per_fmu(ring_ssp: Path, cache: Path) -> None:
    result = run(ring_ssp, 0.3, cache=cache)
    assert {name: t.steps for name, t in result.times.items()} == {
        "src": 1200, "a": 1200, "a2": 1200, "b": 600, "c": 10,
    }  # fmt: skip
    for name, spent in result.times.items():
        assert 0 < spent.worst <= spent.seconds < result.wall, name
    silent = run(ring_ssp, 0.3, timing=False, cache=cache)
    assert silent.times["a"].seconds == 0
    assert silent["c.y"].tobytes() == result["c.y"].tobytes()


def test_progress_reaches_the_end_and_interrupt_leaves_nothing(ring_ssp: Path, cache: Path) -> None:
    seen: list[tuple[float, float]] = []
    run(ring_ssp, 2.0, progress=lambda done, total: seen.append((done, total)), cache=cache)
    assert seen[-1] == (2.0, 2.0)
    assert len(seen) > 3
    assert [s[0] for s in seen] == sorted(s[0] for s in seen)

    def interrupt(done: float, total: float) -> None:
        raise KeyboardInterrupt

    before = open_libraries()
    with pytest.raises(KeyboardInterrupt):
        run(ring_ssp, 2.0, progress=interrupt, cache=cache)
    assert open_libraries() == before


def test_refusal_in_mid_run_names_fmu_call_time_and_reason(narrow_ssp: Path, cache: Path) -> None:
    # stamps reach c (period 4) with the age 4: at its tick n = 48 it is fed 44, beyond 40
    before = open_libraries()
    with pytest.raises(RunError) as error:
        run(narrow_ssp, 1.0, cache=cache)
    text = str(error.value)
    assert text.startswith("c: fmi2SetReal of inputs at t = 0.012 s returned fmi2Error: ")
    assert "u[1] = 44" in text
    assert open_libraries() == before


def test_refused_parameter_names_the_fmus_own_reason(ring_ssp: Path, cache: Path) -> None:
    with pytest.raises(RunError, match=r"^src: .* returned fmi2Error: .*gain = -1, must be posi"):
        run(ring_ssp, 1.0, parameters={"src.gain": -1.0}, cache=cache)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"duration": 0.0}, "duration 0 s: must be a finite time above 0"),
    ({"duration": -1.0}, "duration -1 s: must be a finite time above 0"),
    ({"duration": 0.0001}, "0.4 base steps of 0.00025 s, must be .*at least one, as in 0.00025"),
    ({"duration": 0.0011}, "4.4 base steps of 0.00025 s, must be .*at least one, as in 0.001"),
    ({"duration": float("nan")}, "duration nan s: must be a finite time"),
    ({"duration": float("inf")}, "duration inf s: must be a finite time"),
    ({"duration": 1.0, "signals": ["d.y"]}, "signal 'd.y': there is no component 'd'"),
    ({"duration": 1.0, "signals": ["a.u"]}, "signal 'a.u': in a there is no output 'u'"),
    ({"duration": 1.0, "parameters": {"a.kep": 1.0}}, "no name 'kep', did you mean 'keep'"),
    ({"duration": 1.0, "parameters": {"d.keep": 1.0}}, "parameter 'd.keep': there is no comp"),
    ({"duration": 1.0, "parameters": {"a.keep": [1.0, 2.0]}}, "2 values for 1"),
]


@pytest.mark.parametrize(("arguments", "text"), WRONG, ids=[w[1][:24] for w in WRONG])
def test_wrong_arguments_are_refused(
    ring_ssp: Path, cache: Path, arguments: dict[str, Any], text: str
) -> None:
    with pytest.raises(UsageError, match=text):
        run(ring_ssp, cache=cache, **arguments)


def test_fmu_without_binary_is_refused(ring_ssp: Path, tmp_path: Path, cache: Path) -> None:
    path = replace_binary(ring_ssp, tmp_path, None)
    with pytest.raises(InterfaceError, match=r"relay2.fmu holds no binaries/"):
        run(path, 0.1, cache=cache)


def test_binary_that_does_not_load_is_named(ring_ssp: Path, tmp_path: Path, cache: Path) -> None:
    path = replace_binary(ring_ssp, tmp_path, b"not a library")
    with pytest.raises(RunError, match="b: its library does not load: "):
        run(path, 0.1, cache=cache)


def test_runs_in_several_processes_at_once(ring_ssp: Path, work: Path) -> None:
    # a cache that is empty: they compile at the same time
    jobs = [(str(ring_ssp), str(work / "fresh"))] * 4
    with ProcessPoolExecutor(2) as pool:
        results = list(pool.map(last_of, jobs))
    assert len(set(results)) == 1


def test_compiled_once(cache: Path) -> None:
    assert load(cache) is load(cache)


def last_of(job: tuple[str, str]) -> bytes:
    """Last row of c in a run of its own (called in another process)."""
    path, cache = job
    return bytes(run(path, 0.3, cache=Path(cache))["c.y"][-1].tobytes())


def replace_binary(ssp: Path, folder: Path, content: bytes | None) -> Path:
    """A copy of the .ssp whose relay2.fmu has another binary, or none."""
    inner, target = folder / "relay2.fmu", folder / "changed.ssp"
    with zipfile.ZipFile(ssp) as old:
        inner.write_bytes(old.read("resources/relay2.fmu"))
        with zipfile.ZipFile(inner) as fmu:
            files = {n: fmu.read(n) for n in fmu.namelist()}
        with zipfile.ZipFile(inner, "w") as fmu:
            for name, data in files.items():
                if not name.startswith("binaries/"):
                    fmu.writestr(name, data)
                elif content is not None:
                    fmu.writestr(name, content)
        with zipfile.ZipFile(target, "w") as new:
            for name in old.namelist():
                own = name == "resources/relay2.fmu"
                new.writestr(name, inner.read_bytes() if own else old.read(name))
    return target


def open_libraries() -> set[str]:
    """FMU binaries that are mapped into this process."""
    maps = Path(f"/proc/{os.getpid()}/maps").read_text().splitlines()
    return {line.partition("/")[2] for line in maps if "/binaries/" in line}


def _names(result: Result) -> list[str]:
    return [name for group in result.groups.values() for name in group.signals]
