"""Loops that exist in several forms give the same bits in each: with four doubles at a time, with
two and one by one."""

from __future__ import annotations

import numpy as np
import pytest

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from tests.blocks.loaded import load, machine
from tests.conftest import MACHINE_FILE
from tests.effects.machines import everything

FORMS = ((), ("-DFLEXHEX_NO_QUADS",), ("-DFLEXHEX_NO_VECTORS",))
"""How step.c is compiled: as in the FMU, with AVX where the processor has it; without AVX; without
any vectors."""


def three_axes() -> Machine:
    """The first three actuators alone: an odd number of rows, which share no column."""
    alone = load_machine(MACHINE_FILE.with_name("tflex-actuators.toml"))
    return alone.model_copy(update={"arms": alone.arms[:3]})


MACHINES = {"hexapod": machine, "effects": everything, "axes": three_axes}
"""Rows of the estimator: alike, of unlike widths, an odd number."""


@pytest.mark.parametrize("kind", MACHINES)
@pytest.mark.parametrize("name", ["filter", "estimator"])
def test_block_has_the_same_bits_however_many_it_computes_at_once(name: str, kind: str) -> None:
    blocks = [load(name, MACHINES[kind](), flags) for flags in FORMS]
    rng, starts = np.random.default_rng(9), blocks[0].y.values.copy()
    for block in blocks:
        block.start()
    for _ in range(50):
        inputs = {v.name: rng.uniform(-1, 1, v.count) for v in blocks[0].interface.inputs}
        for block in blocks:
            block.tick(**inputs)
    first, *others = blocks
    assert first.y["fault"] == 0.0
    assert (first.y.values != starts).any()
    for other in others:
        assert np.array_equal(other.y.values, first.y.values)
        assert np.array_equal(other.state, first.state)
