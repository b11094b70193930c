"""Samples in the place of what an input is connected to."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.fmus.common.errors import UsageError
from flexhex.ssp.executor import run
from flexhex.ssp.played import played
from flexhex.ssp.read import read_ssp
from tests.ssp import toys

STEPS = 480
SECONDS = STEPS * 0.00025
SHOWN = ("a.y", "b.y", "c.y")


def test_played_recording_is_what_the_wire_brought(ring_ssp: Path, cache: Path) -> None:
    wired = run(ring_ssp, SECONDS, cache=cache)
    rows = wired["src.r"][:STEPS]
    into = {f"{w.target}.{w.input}" for w in read_ssp(ring_ssp).wires if w.source == "src"}
    assert into == {"a.u[1]", "a.u[2]", "c.v"}
    inputs = {"a.u": rows, "c.v": rows[:, 1]}
    # another gain: what still comes from the source would show
    other = run(ring_ssp, SECONDS, inputs=inputs, parameters={"src.gain": 9.0}, cache=cache)
    for name in SHOWN:
        assert other[name].tobytes() == wired[name].tobytes(), name
    assert not np.array_equal(other["src.r"], wired["src.r"])


def test_each_row_is_taken_at_its_base_step(cache: Path, work: Path) -> None:
    stamps = np.column_stack([np.arange(100.0, 100 + STEPS), np.zeros(STEPS)])
    ssp = toys.pack(toys.chain(1, 4), work / "played")
    result = run(ssp, SECONDS, signals=["c1.y[1]", "c2.y[1]"], inputs={"c1.u": stamps}, cache=cache)
    # sampled at n > 0, shown at n + 1; c2 samples that at every fourth, shows it four later
    assert result["c1.y[1]"][2:].tolist() == stamps[1:, 0].tolist()
    assert result["c2.y[1]"][2:].tolist() == stamps[3:-1:4, 0].tolist()


def test_system_in_memory_runs_like_its_file(ring_ssp: Path, cache: Path) -> None:
    package = read_ssp(ring_ssp)
    one, other = run(package, SECONDS, cache=cache), run(ring_ssp, SECONDS, cache=cache)
    assert one["c.y"].tobytes() == other["c.y"].tobytes()
    assert set(other.meta) - set(one.meta) == {"sha256 ssp"}


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"d.u": np.zeros((STEPS, 2))}, "input 'd.u': there is no component 'd'"),
    ({"a.y": np.zeros((STEPS, 2))}, "input 'a.y': in a there is no input 'y'"),
    ({"a.u": np.zeros((STEPS, 3))}, "samples of shape (480, 3), needed are 480 rows, one for"),
    ({"a.u": np.zeros((STEPS - 1, 2))}, "samples of shape (479, 2), needed are 480 rows, one for"),
    ({"a.v": np.where(np.arange(STEPS) == 7, np.nan, 0.0)}, "input 'a.v': row 7 is not finite"),
]


@pytest.mark.parametrize(("inputs", "text"), WRONG, ids=[w[1][:24] for w in WRONG])
def test_wrong_samples_are_refused(
    ring_ssp: Path, cache: Path, inputs: dict[str, Any], text: str
) -> None:
    with pytest.raises(UsageError, match=re.escape(text)):
        run(ring_ssp, SECONDS, inputs=inputs, cache=cache)


def test_whole_number_is_wanted_where_the_fmu_takes_an_integer(ring_ssp: Path) -> None:
    package = read_ssp(ring_ssp)
    first = package.instance("a")
    v = first.fmu.variables["v"]
    fmu = replace(first.fmu, variables={"v": replace(v, type="Integer")})
    whole = replace(package, instances=(replace(first, fmu=fmu),))
    assert played(whole, {"a.v": np.array([1.0, 2.0])}, 2).rows.tolist() == [[1.0], [2.0]]
    with pytest.raises(UsageError, match=r"input 'a\.v': v = 2\.5, must be a whole number"):
        played(whole, {"a.v": np.array([1.0, 2.5])}, 2)
