"""A log larger than the memory allowed is read in stretches, within a measured bound."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import Options, read_log
from tests.diagnosis.synthetic import columns, motion, plain_csv, write_csv, write_hdf5

READ = """
import sys
from flexhex.diagnosis.logs import Options, read_log
def peak():
    # not ru_maxrss: that begins with the size of the process that forked this one
    lines = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))
before = peak()
read_log(sys.argv[1], Options(memory=float(sys.argv[2])))
print(peak() - before)
"""


def grown(path: Path, budget: float) -> float:
    """Megabytes by which a process grows when it reads a log."""
    command = [sys.executable, "-c", READ, str(path), str(budget)]
    env = {"PYTHONPATH": ":".join(sys.path)}
    done = subprocess.run(command, capture_output=True, text=True, env=env, check=True)
    return float(done.stdout)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="wants Linux' /proc")
def test_memory_stays_within_the_bound(tmp_path: Path) -> None:
    """A file of 57 MB with 33 MB of samples, 8 MB allowed.

    Beside the samples (a fifth more room) the parser holds a block of 8 MB as text and as numbers:
    17 MB were measured, 73 MB without a bound.
    """
    names, units, values = columns(motion(20.0, n=6))
    path = write_csv(tmp_path / "a.csv", names, units, values)
    head, rows = path.read_text().split("N m\n", 1)
    cut = [line.split(",", 1)[1] for line in rows.splitlines()]
    with path.open("w") as file:
        file.write(head + "N m\n")
        for k in range(8):
            base = k * len(cut)
            file.writelines(f"{(base + j) * 5e-4:.4f},{line}\n" for j, line in enumerate(cut))
    assert path.stat().st_size > 5e7
    few, all_of_it = grown(path, 8e6), grown(path, 1e9)
    assert few < 35
    # the same reader without a bound holds all of them
    assert all_of_it > few + 20


@pytest.mark.parametrize("ending", ["csv", "h5"])
def test_stretches_keep_true_times_and_values(ending: str, tmp_path: Path) -> None:
    run = motion(20.0)
    path = tmp_path / f"a.{ending}"
    write = plain_csv if ending == "csv" else write_hdf5
    log = read_log(write(path, run), Options(memory=40 * 20_000))
    channel = log["theta"]
    assert 0.4 < channel.valid.sum() / 40_000 < 0.6
    assert len(channel.breaks) == 23
    rows = np.rint(channel.time[channel.valid] / 5e-4).astype(int)
    assert np.array_equal(channel.values[channel.valid], run["theta"][rows])
    # spread over all of the run
    assert (rows.min() < 100, rows.max() > 39_900) == (True, True)
    (finding,) = [f for f in log.findings if f.kind == "memory"]
    assert "24 evenly spread stretches (50%)" in finding.text
