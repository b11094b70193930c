"""Motions drawn at random, each ended at random: `python -m tests.gateway.sweep SEED --count 150`.

A line for each that says what became of it; exit code 1 if one must not be. Wants root, cargo and
`flexhex build`. An axis that loses its power falls, and may meet a stop.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.conftest import ROOT
from tests.gateway.motions import ENDS, FAULTS, HELD_BY_FIVE, drawn, ended

OUTCOMES = ("WRONG", "refused", "faster than 1 rad/s", "on its stop", "landed", "fell")


def main() -> int:
    """Run them; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int)
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--other", action="store_true", help="a machine that is not the model")
    parser.add_argument("--landings", action="store_true", help="no faults that take the power")
    parser.add_argument(
        "--five",
        choices=("damp", "zero", "quick_stop"),
        help="only faults that leave five drives, with this stop",
    )
    words = parser.parse_args()
    ssp = ROOT / "out" / "hexapod.ssp"
    plant = ROOT / "out" / "machine" / "hexapod.ssp" if words.other else None
    counts: Counter[str] = Counter()
    hows = ENDS if words.landings else (*ENDS, *FAULTS)
    motions = drawn(words.seed, words.count, hows)
    for motion in (m for m in motions if words.five is None or m.how in HELD_BY_FIVE):
        with tempfile.TemporaryDirectory() as folder:
            try:
                text = ended(motion, ssp, Path(folder), plant, words.five)
            except AssertionError as why:
                text = f"WRONG {str(why).splitlines()[0] if str(why) else 'without a word'}"
        counts[next(outcome for outcome in OUTCOMES if outcome in text)] += 1
        print(f"{motion}: {text}", flush=True)
    print(dict(counts))
    return 1 if counts["WRONG"] else 0


if __name__ == "__main__":
    sys.exit(main())
