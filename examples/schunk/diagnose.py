"""Diagnose the measured arm: fitted to runs 1 to 12, judged on 40, 60, 80 and 100.

python examples/schunk/diagnose.py [--json]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose

FITTED, LOCKED = range(1, 13), (40, 60, 80, 100)


def run(number: int) -> Path:
    """File of a run."""
    return Path(__file__).parent / f"run_{number:03d}.csv"


def show(diagnosis: Diagnosis) -> None:
    """Verdict, effects with 95 % intervals, and the residual of each axis on the held-out runs."""
    print(f"verdict: {diagnosis.verdict}")
    for effect in diagnosis.effects:
        print(f"{effect.title}, axes {effect.axes}, rivals {effect.rivals}")
        for name, value in effect.parameters.items():
            low, high = value.ci95
            print(f"  {name} = {value.value:.3g} ({low:.3g} to {high:.3g}) {value.unit}")
    print("residual on the held-out runs [N m]: before, after")
    held_out = diagnosis.residual.held_out
    for axis, pair in enumerate(zip(held_out["before"], held_out["after"], strict=True), start=1):
        print(f"  axis {axis}: {pair[0]:.2f}  {pair[1]:.2f}")
    for note in diagnosis.notes:
        print(f"- {note}")


if __name__ == "__main__":
    options = Options(base=str(Path(__file__).with_name("lwa4p.toml")))
    result = diagnose([run(k) for k in FITTED], [run(k) for k in LOCKED], options=options)
    if "--json" in sys.argv[1:]:
        print(json.dumps(result.data()))
    else:
        show(result)
