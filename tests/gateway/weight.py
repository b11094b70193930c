"""A machine with weight: at rest before the first frame, free from then on, and where it ends."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from tests.gateway.bench import Bench, Event, Ran, Rows, columns
from tests.gateway.fault_table import Fall
from tests.oracles.machine import TFLEX

REST_S = 5.0
"""Time that the machine sinks before the first frame, and after the last."""
QUIET_S = 60.0
"""The model has hardly any damping: after this time it rests."""
BRAKING = 1.8
"""Torque over speed of short-circuited windings [N m s/rad]: K_t^2 / R of 3 N m/A and 5 ohm."""
STROKE: float = tomllib.loads(TFLEX.read_text())["geometry"]["stroke"]["value"]
"""End stops [rad]."""
FASTEST = 1.0
"""Highest speed that a reaction may cause [rad/s]."""
TS = 0.00025


@dataclass(frozen=True)
class Fallen:
    """A run, and the log of what the machine did from enabling to rest."""

    ran: Ran
    log: Path

    @cached_property
    def _table(self) -> dict[str, Rows]:
        """Its columns, which take longer to read than a short run takes; none without a frame."""
        return columns(self.log) if self.log.stat().st_size > 1000 else {}

    @property
    def theta(self) -> Rows:
        """Angles (cycles, 6) [rad]."""
        return self._table.get("theta", np.empty((0, 6)))

    @property
    def tau(self) -> Rows:
        """Torques (cycles, 6) [N m] that the drives were sent."""
        return self._table.get("tau", np.empty((0, 6)))

    @cached_property
    def speed(self) -> Rows:
        """Largest speed of the axes in each cycle, mean over 1 ms [rad/s]."""
        moved = np.abs(self.theta[4:] - self.theta[:-4]).max(axis=1)
        return moved / (4 * TS)  # type: ignore[no-any-return]

    def ends_at_rest(self, since: int) -> None:
        """From this cycle on no axis is faster than allowed or leaves its stroke; then all rest.

        An axis may be as fast as it was before: braking begins there.
        """
        before = 1.02 * self.speed[max(since - 8, 0)]
        assert self.speed[since:].max() <= max(FASTEST, before), self.ran.words
        assert np.abs(self.theta[since:]).max() <= STROKE
        last = self.theta[-2000:]
        # the model has hardly any damping in its flexures: what is left is a slow swing
        assert np.ptp(last, axis=0).max() < 0.1
        assert not np.any(np.abs(self.tau[-2000:]) > 1.0)

    @property
    def ended(self) -> int:
        """Cycle in which the run was ended, and the landing began."""
        after = round(REST_S / TS) + int(self.ran.one("summary")["cycles_to_disabled"])
        return len(self.theta) - after

    def fall(self, fault: str, since: int, step: int | None = None) -> Fall:
        """The row of this run; the fault was at cycle `since`, or at `step` of the controller."""
        summary = self.ran.one("summary")
        rule, stop, cycles = "none", "–", None
        if summary["landing_trip"]:
            rule = "reported at the end"
        for trip in (e for e in self.ran.events if e["event"] == "trip"):
            rule, stop = trip["reason"], trip["reaction"]
            cycles = self._index(trip["cycle"]) - since if step is None else trip["cycle"] - step
        unknown = tuple(summary["not_disabled"])
        return self.row(fault, rule, stop, since, cycles=cycles, unknown=unknown)

    def row(
        self,
        fault: str,
        rule: str,
        stop: str,
        since: int,
        *,
        cycles: int | None = None,
        unknown: tuple[int, ...] = (),
    ) -> Fall:
        """The row with what the machine did from the cycle `since` on, and where its drives are."""
        speed, angle = self.speed[since:].max(), np.abs(self.theta[since:]).max()
        return Fall(fault, rule, stop, cycles, speed, angle, self.drives(), unknown)

    def _index(self, cycle: int) -> int:
        """Cycles since the drives were enabled in a cycle of the controller."""
        summary = self.ran.one("summary")
        lifted = int(summary["lifted"])
        # cycles of a lift-off count down to the controller's first, without those that were skipped
        return lifted + 1 + cycle if cycle >= 0 else lifted + int(summary["skipped"])

    @property
    def stopped(self) -> Event:
        """What the drives' process says at its end, of all that happened since the first frame."""
        return self.ran.happened("stopped")[0]

    def drives(self) -> str:
        """States in which the drives ended, with their axes where they differ."""
        axes: dict[str, list[str]] = {}
        for axis, state in enumerate(self.stopped["drives"], 1):
            axes.setdefault(state, []).append(str(axis))
        if len(axes) == 1:
            return next(iter(axes))
        return ", ".join(f"{state}: {' '.join(k)}" for state, k in axes.items())

    def disabled(self) -> list[int]:
        """Positions whose drive ended without power."""
        off = {"switch on disabled", "ready to switch on", "fault"}
        return [k for k, state in enumerate(self.stopped["drives"]) if state in off]

    def refused(self, fault: str, stop: str = "no power") -> Fall:
        """The row of a run that was refused, with what the machine did since the first frame."""
        end = self.stopped
        moved = end["fastest"], end["farthest"]
        return Fall(fault, "refused", stop, None, *moved, self.drives(), ())


def free(
    bench: Bench,
    options: str = "",
    *,
    braking: float = BRAKING,
    resting: float = REST_S,
    changes: Sequence[tuple[str, str]] = (),
    **more: Any,
) -> Fallen:
    """A run against a machine that nothing holds; resting: time before the first frame [s]."""
    # one file for each run: what an earlier one did may be read after a later one
    log = bench.folder / f"drives-{len(list(bench.folder.glob('drives-*.csv')))}.csv"
    text = f'log = "{log}"\nplant.resting_s = {resting}\ndrives.braking = {braking}\n'
    ran = bench.run(options=text + options, changes=changes, **more)
    return Fallen(ran, log)
