"""From files to an answer: read, group, calibrate, search, judge on the locked runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import joint
from flexhex.diagnosis.blocks import Run
from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.changed import changes
from flexhex.diagnosis.compiled import Compiled, compiled
from flexhex.diagnosis.confusion import confusion
from flexhex.diagnosis.drifts import drifts_of, without
from flexhex.diagnosis.drives import drives_of
from flexhex.diagnosis.fit import beside
from flexhex.diagnosis.gaps import Before, before_of, gap_of
from flexhex.diagnosis.guard import delayed, poor_axes
from flexhex.diagnosis.maps import maps
from flexhex.diagnosis.naming import tried_of
from flexhex.diagnosis.prepare import Asked, Options, asked_of, fitted, misfit
from flexhex.diagnosis.selection.choose import carrying
from flexhex.diagnosis.selection.side import selected
from flexhex.diagnosis.sides import Side, SideOf, side_of
from flexhex.diagnosis.verdict import Changed, Diagnosis, Named
from flexhex.fmus.common.effects import Effect, library

Array = NDArray[np.float64]
RANGE, LITTLE_KNOWN = (0.4, 2.5), (0.0, 20.0)
"""Smallest and largest change of a parameter that is believed, relative: of what a drawing tells,
and of damping, which it does not."""
SEARCHES, BENT = 3, 0.05
"""Searches of the mechanism at most; relative change of a width that asks for another one."""
Progress = Callable[[str, int, int], None]
USUAL, QUICK = Options(), Options(confidence=0)
"""What `flexhex diagnose` does, and the same without measuring its confidence."""
__all__ = ["Options", "diagnose", "diagnose_files", "silent"]


def silent(text: str, done: int, total: int) -> None:
    """A progress that nobody watches."""


def diagnose(
    paths: Sequence[Path],
    locked: Sequence[Path] = (),
    machine_file: Path | None = None,
    options: Options = USUAL,
    progress: Progress = silent,
) -> Diagnosis:
    """Find where model and data disagree, and name what is missing.

    Raises LogError, MachineError or UsageError for what cannot be read or does not fit.
    """
    progress("reading", 0, 5)
    base, asked, trouble = asked_of(paths, locked, machine_file, options)
    if trouble:
        return asked.cannot_tell(trouble)
    progress("fitting the base model", 1, 5)
    made, coarse, smoothed = fitted(base, asked.runs)
    if smoothed:
        asked = replace(asked, findings=(*asked.findings, smoothed), coarse=coarse)
    trouble = misfit(made)
    if trouble and options.selection:
        # a payload may be most of what does not fit
        bench = carrying(Bench(made, compiled(made.base.n, _sought(asked), made.base.holds)))
        made, trouble = bench.made, misfit(bench.made)
    if trouble:
        return asked.cannot_tell(trouble)
    return _searched(made, asked, options, progress)


def _searched(made: Calibrated, asked: Asked, options: Options, progress: Progress) -> Diagnosis:
    """The answer for a base model that fits the runs well enough."""
    n, judged = made.base.n, asked.judged
    known = compiled(n, _sought(asked), made.base.holds)
    search: SideOf = selected if options.selection else side_of
    before, settled = _mechanism(made, known, judged, lambda text: progress(text, 2, 5), search)
    made, sides = settled.held.bench.made, [settled]
    poor = poor_axes(made, sides[0].held.residual)
    if len(poor) == n:
        return asked.cannot_tell("; ".join(sides[0].notes))
    progress("commanded against reported torque", 3, 5)
    sides += drives_of(made, [block.run for block in made.blocks], judged, search)
    drifts = drifts_of(settled, judged)
    if drifts and settled.held.parts:
        drift, steady = drifts[0].held, without(settled.held, drifts[0].held)
        made.forget()
        del settled, drifts, sides[0]
        made = steady
        settled = search(Bench(made, known), judged, lambda text: progress(text, 3, 5), drift=drift)
        sides.insert(0, settled)
        drifts = drifts_of(settled, judged)
    sides += drifts
    named = [effect for side in sides for effect in side.named]
    main = next((side for side in sides if side.matters), sides[0])
    notes = list(dict.fromkeys(note for side in sides for note in side.notes))
    extended = made.regression
    if sides[0].held.parts:
        extended = extended.extended([part.columns for part in sides[0].held.parts])
    changed = _plausible(changes(extended, made.known, made.base.directions()), named)
    payloads = settled.payloads
    verdict = _verdict(made, sides, named, [*payloads, *changed], notes, asked.coarse)
    progress("measuring confidence", 4, 5)
    if named and options.confidence:
        named = [
            confusion(side.held, effect, options.confidence)
            for side in sides
            for effect in side.named
        ]
    progress("done", 5, 5)
    return Diagnosis(
        verdict,
        tuple(named),
        payloads if verdict in ("unknown", "cannot tell") else (*payloads, *changed),
        gap_of(before if main is settled else before_of(main), main),
        tried_of(main.rounds),
        maps(main.held),
        tuple(notes),
        (*asked.findings, *filter(None, [delayed(made)])),
        *asked.names,
    )


def _mechanism(
    made: Calibrated,
    known: Sequence[Compiled],
    judged: Sequence[Run],
    say: Callable[[str], None],
    search: SideOf,
) -> tuple[Before, Side]:
    """What the mechanism lacks, beside the base model as it settles; and what the first fit left.

    What is missing bends the fit of the widths, and a bent fit asks for effects that are not
    there; so the search begins anew beside the base model that its own answer leaves.
    """
    found = search(Bench(made, known), judged, say)
    before = before_of(found)
    for _ in range(SEARCHES - 1):
        chosen = [r.chosen for r in found.rounds if r.chosen]
        held = found.held if found.held.parts else joint(found.held.bench, chosen)
        if not held.parts:
            break
        # the columns and rows of one search at a time: they take most of the memory
        found.held.bench.forget()
        settled = beside(held)
        if np.abs(np.log(settled.fitted.widths / made.fitted.widths)).max(initial=0.0) < BENT:
            break
        del found, held
        made = settled
        found = search(Bench(made, known), judged, say)
    return before, found


def _sought(asked: Asked) -> dict[str, Effect]:
    """The library for the mechanism: what the drives themselves do shows where logs have the
    command, so that less of it can stand behind their reports."""
    told = all(run.command is not None for run in asked.runs)
    return {id: (effect.behind or effect) if told else effect for id, effect in library().items()}


def _plausible(changed: Sequence[Changed], named: Sequence[Named]) -> list[Changed]:
    """Changes that no effect found on the same axis could have taken part in.

    An effect that acts through the inertias leaves none of them to be trusted.
    """
    axes = {axis for effect in named for axis in effect.axes}
    own = tuple(f"[{axis}" for axis in axes)
    apart = [c for c in changed if not any(mark in c.parameter for mark in own)]
    return [c for c in apart if not named or _possible(c)]


def _possible(change: Changed) -> bool:
    """Whether a parameter could have such a value: not half or twice what it was, but for damping.

    What is less than its own uncertainty has no such measure: it may have either sign.
    """
    value, nominal = change.estimate.value, change.nominal
    low, high = change.estimate.ci95
    small = abs(nominal) <= max((high - low) / 2, 1e-9)
    least, most = LITTLE_KNOWN if change.estimate.unit == "N m s/rad" else RANGE
    return small or (least < value / nominal < most)


def diagnose_files(
    paths: Sequence[Path],
    locked: Sequence[Path],
    machine_file: Path | None = None,
    options: Options = QUICK,
) -> dict[str, Any]:
    """`diagnose` as the data of `--json`."""
    return diagnose(paths, locked, machine_file, options).data()


def _verdict(
    made: Calibrated,
    sides: Sequence[Side],
    named: Sequence[Named],
    changed: Sequence[Changed],
    notes: list[str],
    coarse: Array,
) -> str:
    if named:
        return "set" if any(effect.rivals for effect in named) else "named"
    if not made.noise.repeats:
        notes.append("no trajectory was run twice: what does not repeat cannot be set apart")
        strange = [change.parameter for change in changed if not _possible(change)]
        if strange:
            notes.append(f"{', '.join(strange)} would fit best with a value that cannot be")
        return "changed" if changed and not strange else "cannot tell"
    if any(side.remains for side in sides):
        if all(coarse[axis] > 0.0 for side in sides for axis in side.remains):
            notes.append(
                "it may be the error of the encoder, which repeats: finer angles would tell"
            )
            return "cannot tell"
        return "unknown"
    if not all(_possible(change) for change in changed):
        notes.append(
            "only impossible parameters could explain the runs: something is missing that the"
            " library does not tell from them"
        )
        return "unknown"
    return "changed" if changed else "none"
