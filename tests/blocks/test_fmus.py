"""Every FMU gives what its block gives, to the last bit, at the times of the timing rule.

The other tests of this folder call step.c directly; this one makes them hold for the FMUs.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

from flexhex.fmugen.blocks import BLOCKS, build_block
from tests.blocks.loaded import Array, Struct, load, machine
from tests.conftest import OBJECTS
from tests.typed import outputs_of, values_of

STARTS: dict[str, dict[str, float]] = {"reference": {"t_start": 0.00025}}
"""Other parameters than the default ones: the reference would stand still for two seconds."""


@contextmanager
def running(fmu: Path, folder: Path) -> Iterator[Any]:
    """The FMU in initialised mode, at t = 0."""
    description = fmpy.read_model_description(str(fmu))
    fmpy.extract(str(fmu), str(folder))
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="subject",
    )
    slave.instantiate()
    slave.outputs = outputs_of(description)
    initialise(slave)
    yield slave
    slave.terminate()
    slave.freeInstance()


def initialise(slave: Any) -> None:
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()


def wandering(inputs: Struct, low: Array, high: Array, steps: int) -> Iterator[Array]:
    """Inputs for each base step: their start values and up to 0.05 beside, within the range."""
    rng, middle = np.random.default_rng(17), inputs.values.copy()
    for _ in range(steps):
        yield np.clip(middle + rng.uniform(-0.05, 0.05, middle.size), low, high)


def compare(slave: Any, block: str, ticks: int) -> None:
    """Step the FMU and its block side by side; every base step all outputs must be equal."""
    subject = load(block)
    interface, base = subject.interface, machine().timing.base
    every = round(interface.Ts / base)
    n_p, n_u = subject.p.size, subject.u.size
    low, high = (
        np.array([getattr(v, end) for v in interface.inputs for _ in range(v.count)] or [0.0])
        for end in ("min", "max")
    )
    inputs = list(range(n_p, n_p + n_u))
    first = subject.start(**STARTS.get(block, {})).values.copy()
    pending = published = first
    assert np.array_equal(values_of(slave, slave.outputs), published), "first outputs"
    for n, u in enumerate(wandering(subject.u, low, high, every * ticks)):
        if n_u:
            slave.setReal(inputs, u.tolist())
        slave.doStep(n * base, base)
        if n >= 1 and n % every == 0:
            subject.u.values[:] = u
            pending = subject.tick().values.copy()
        if (n + 1) % every == 0:
            published = pending
        actual = np.array(values_of(slave, slave.outputs))
        assert np.array_equal(actual, published), f"base step {n + 1}"
        assert np.isfinite(actual).all()
    assert not np.array_equal(pending, first), "nothing happened"


@pytest.mark.sample(4)
@pytest.mark.parametrize("block", BLOCKS)
def test_fmu_equals_its_block_also_after_reset(block: str, tmp_path: Path) -> None:
    fmu = build_block(block, machine(), tmp_path / "fmu", STARTS.get(block, {}), cache=OBJECTS)
    with running(fmu, tmp_path / "unzipped") as slave:
        compare(slave, block, ticks=12)
        slave.reset()
        initialise(slave)
        compare(slave, block, ticks=12)
