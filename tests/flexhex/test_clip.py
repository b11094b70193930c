"""The moving picture of the report."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.fmus.common.machine_file import load_machine
from flexhex.run.clip import FARTHEST, clip
from tests.conftest import MACHINE_FILE
from tests.flexhex.test_view import LARGEST, data_of, numbers, run_of


def paper_run(larger: float, machine: Any = None) -> Any:
    """Two outcomes; the errors of feedback only are `larger` times those of `run_of`."""
    made = {name: run_of(seconds=9.0) for name in ("feedback", "adaptive")}
    made["feedback"]["feedback.e"][:] *= larger
    outcomes = {
        name: SimpleNamespace(case=SimpleNamespace(name=name, title=f"{name} title"), result=result)
        for name, result in made.items()
    }
    builder = SimpleNamespace(machine=machine or load_machine(MACHINE_FILE))
    table = SimpleNamespace(of=outcomes.__getitem__)
    return SimpleNamespace(builder=builder, table=table, adaptive=outcomes["adaptive"])


@pytest.mark.parametrize("larger", [1.0, 40.0])
def test_clip_shows_both_runs_with_an_error_that_is_seen(larger: float) -> None:
    """20 urad is magnified by 1000, the most; 800 urad by less, so that it stays below FARTHEST."""
    found = clip(paper_run(larger))
    assert found is not None
    data = data_of(found.page)
    assert [run["name"] for run in data["runs"]] == ["feedback title", "adaptive title"]
    assert (data["begin"], data["end"], data["begins"]["ghost"]) == (2.0, 6.0, "beside")
    factor = data["begins"]["factor"]
    most = max(np.abs(numbers(run["frames"]["e"])).max() for run in data["runs"])
    assert factor * most <= FARTHEST
    assert factor == 1000 or factor * most * 10**0.25 > FARTHEST
    assert f"drawn {factor:.2g} times" in found.text
    assert len(found.page) < LARGEST, "the report stays small"


def test_machine_without_a_platform_has_no_clip() -> None:
    alone = load_machine(MACHINE_FILE.with_name("tflex-actuators.toml"))
    assert clip(paper_run(1.0, alone)) is None
