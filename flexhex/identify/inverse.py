"""`identify --fmu FILE`: the identified inverse dynamics as an FMU."""

from __future__ import annotations

from pathlib import Path

from flexhex.diagnosis.estimation.inverse import inverse_model
from flexhex.diagnosis.estimation.records import Identified
from flexhex.fmugen import cache as store
from flexhex.fmugen.blocks import step_file
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.inverse import equations, interface

BASE_STEP = 5e-5
"""Time between two instants at which the FMU can act [s]: 20 kHz, the fastest usual drive."""


def write_fmu(path: Path, identified: Identified) -> Path:
    """Build the FMU. Its sample time `Ts` is that of the logs, and a parameter.

    Raises BuildError without a C compiler, UsageError or MachineError as `inverse_model`.
    """
    ts = identified.estimated.model.blocks[0].run.motion.ts
    steps = max(1, round(ts / BASE_STEP))
    with SYMBOLIC:
        model = inverse_model(identified)
        return build_fmu(
            interface.interface(path.stem, model, steps * BASE_STEP),
            equations.functions(model),
            step_file("inverse"),
            path.parent,
            BASE_STEP,
            store.objects(path.parent / "cache"),
        )
