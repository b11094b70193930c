"""Families of truth that share no code with each other, the diagnosis or its library of effects.

- `generator`: the default hexapod by a mechanism of our own (`studies/generator`)
- `closed`: the same, integrated in its closed loop; minutes a case
- `mujoco`: machines in MuJoCo (`studies/mujoco`)
- `axes`: plain rotary axes with friction and cogging (`studies/axes.py`)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from studies import axes, axes_files
from studies.generator.closed import closed_case, simulate_closed
from studies.generator.draw import Case, draw
from studies.generator.inverse import simulate
from studies.generator.write import write
from studies.mujoco.make import make, refuse

HEXAPOD = Path("machines") / "tflex.toml"
CLOSED = Path("out") / "hidden" / "closed"
"""Cache of integrated closed loops."""


@dataclass(frozen=True)
class Files:
    """Logs to fit, logs for tests, machine file; the sealed truth, which the scorer alone opens."""

    paths: tuple[Path, ...]
    test_paths: tuple[Path, ...]
    machine_file: Path
    sealed: Path


Family = Callable[[int, Path, Path, str | None], Files]
"""Seed, folder of the logs, folder of the truth, category instead of the one drawn."""


def _generator(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    _no_category("generator", category)
    return _written(draw(seed), logs, sealed)


def _closed(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    _no_category("closed", category)
    return _written(closed_case(seed), logs, sealed)


def _no_category(family: str, category: str | None) -> None:
    if category is not None:
        raise ValueError(f"category {category!r}: family {family} draws its own")


def _bare_generator(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    return _written(replace(draw(seed), hidden=(), category="nothing"), logs, sealed)


def _bare_closed(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    return _written(replace(closed_case(seed), hidden=(), category="nothing"), logs, sealed)


def _bare_mujoco(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    case = make(seed, logs, sealed, category=category, test=True, bare=True)
    return Files(case.paths, case.test_paths, case.machine_file, case.sealed)


def _written(case: Case, logs: Path, sealed: Path) -> Files:
    clean = simulate_closed([case], CLOSED)[0] if case.closed else simulate(case)
    # every ninth case as CSV: slower to read, the same numbers
    written = write(case, clean, logs, sealed, "csv" if case.seed % 9 == 4 else "h5")
    return Files(written.paths, written.held_out, HEXAPOD, written.sealed)


def _mujoco(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    # test seeds are refused before, for all families alike
    case = make(seed, logs, sealed, category=category, test=True)
    return Files(case.paths, case.test_paths, case.machine_file, case.sealed)


def _axes(seed: int, logs: Path, sealed: Path, category: str | None = None) -> Files:
    _no_category("axes", category)
    case = axes_files.write(axes.draw(seed), logs, sealed)
    return Files(case.paths, case.test_paths, case.machine_file, case.sealed)


FAMILIES: Mapping[str, Family] = {
    "generator": _generator,
    "closed": _closed,
    "mujoco": _mujoco,
    "axes": _axes,
}
BARE: Mapping[str, Family] = {
    "generator": _bare_generator,
    "closed": _bare_closed,
    "mujoco": _bare_mujoco,
}
"""The same machine, motions and noise with nothing hidden: what a residual is without the effect.
The base model of plain axes is exact, so that nothing of theirs repeats."""
__all__ = ["FAMILIES", "Family", "Files", "refuse"]
