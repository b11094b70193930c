"""This working tree against another revision, side by side: what has become slower?

Each benchmark runs in both trees in turn (A B A B ...), as a process of its own, so that the
computer's speed and load are the same for both. Slower means by more than WORSE in the median of
the ratios and in the best times too: a burst of other work makes nothing slower.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.waits import COMMANDS, spent
from flexhex.fmus.common.errors import RunError

WORSE = 1.15
TURNS = 5
RECORDED = "recorded"
"""Stands for the revision that results/speed.json was measured at."""
SPEED = Path("results") / "speed.json"
BLOCKS = ("N", "chain", "kalman", "plant", "adapter")
"""Benchmarks in C; the old tree measures its own with its own benchmarks."""
WAITS = ("help", "check", "warm", "quick")


@dataclass(frozen=True)
class Change:
    """One benchmark in both trees: best times [ns] and the median of the ratios now / before."""

    key: str
    what: str
    before: float
    now: float
    ratio: float

    @property
    def worse(self) -> bool:
        """Whether it has become slower by more than WORSE, whichever way one looks at it."""
        return min(self.ratio, self.now / self.before) > WORSE


def change(key: str, what: str, before: Sequence[float], now: Sequence[float]) -> Change:
    """From times [ns] taken in turn."""
    ratio = float(np.median(np.divide(now, before)))
    return Change(key, what, min(before), min(now), ratio)


def compare(revision: str, keys: Sequence[str], turns: int = TURNS) -> list[Change]:
    """Changes of the benchmarks of those keys since a revision. RunError when there is none."""
    here = Path.cwd()
    with worktree(commit(revision, here), here) as there:
        rows = []
        for key in keys:
            most = min(turns, COMMANDS[key].most) if key in COMMANDS else turns
            # the first time is not counted: it fills the caches
            pairs = [(measured(key, there), measured(key, here)) for _ in range(most + 1)][1:]
            before, now = ([time for _, time in side] for side in zip(*pairs, strict=True))
            rows.append(change(key, pairs[0][1][0], before, now))
        return rows


def recorded() -> dict[str, float]:
    """Benchmark -> median of what results/speed.json has of it; nothing where there is none."""
    if not SPEED.exists():
        return {}
    rows = json.loads(SPEED.read_text(encoding="utf-8"))["results"]["rows"]
    return {row["key"]: float(row["timings"][0]["median"]) for row in rows}


def commit(revision: str, here: Path) -> str:
    """The commit that a revision names; RunError when this repository does not have it."""
    named = revision
    if revision == RECORDED:
        named = json.loads((here / SPEED).read_text(encoding="utf-8"))["provenance"]["commit"]
    done = _git(here, "rev-parse", "--verify", "--quiet", f"{named}^{{commit}}")
    if done.returncode:
        raise RunError(
            f"--against {revision}: no commit {named} in this repository; fetch its history, or"
            " name a revision that it has"
        )
    return done.stdout.strip()


@contextmanager
def worktree(commit: str, here: Path) -> Iterator[Path]:
    """A working tree of a commit, for as long as it is needed."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "before"
        done = _git(here, "worktree", "add", "--detach", str(tree), commit)
        if done.returncode:
            raise RunError(f"git worktree add: {done.stderr.strip()}")
        try:
            yield tree
        finally:
            _git(here, "worktree", "remove", "--force", str(tree))


def measured(key: str, tree: Path) -> tuple[str, float]:
    """What a benchmark is, and its time in a working tree [ns]."""
    if key in COMMANDS:
        return COMMANDS[key].what, spent(COMMANDS[key], tree)
    words = [sys.executable, "-m", "benchmarks", "--json", "--only", key, "--rounds", "5"]
    done = subprocess.run(words, cwd=tree, capture_output=True, text=True, check=False)
    try:
        row = json.loads(done.stdout)["rows"][0]
    except ValueError:
        raise RunError(f"benchmarks --only {key} in {tree}: {done.stderr.strip()[-500:]}") from None
    return row["what"], row["timings"][0]["median"]


def _git(here: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["git", *arguments], cwd=here, capture_output=True, text=True, check=False
    )
