"""What to do after a diagnosis: a sentence, and the command that does it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, takewhile
from pathlib import Path

import numpy as np

from flexhex.diagnose.numbers import listed, number
from flexhex.diagnose.titles import title, where
from flexhex.diagnosis.prepare import ONE_TRAJECTORY
from flexhex.diagnosis.result.verdict import MEND, Diagnosis, Named, Residual
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.effects.own import own_effect
from flexhex.fmus.common.errors import MachineError

NOT_OF_IDENTIFY = ("--out", "-o", "--report")
"""Options of `diagnose` with a value that `identify` has not."""
OF_THE_FILE = ("geometry=", "gravity=")
"""Tolerances with which `identify` builds no FMU."""
FAR = 3.0
"""Residual with the file's values, relative to that with the fitted ones, that asks for these."""
MANY = 3
"""Files from which on a command shows their pattern."""
APPLICABLE = ("named", "ambiguous", "changed")
"""Verdicts with something to add to the machine file."""


@dataclass(frozen=True)
class Invocation:
    """The command as it was typed, word by word, for the suggestion of the next one; data: the file
    that keeps what was found."""

    words: tuple[str, ...]
    base: str = "hexapod"
    data: str = "diagnosis.json"

    def fit(self) -> str:
        """The command that fits the base model alone."""
        return joined(self._identify)

    def identify(self) -> str:
        """The command that fits what was found and builds it."""
        more = ("--diagnosis", self.data, "--out", "identified", "--fmu", "inverse.fmu")
        return joined([*self._identify, *more])

    @property
    def _identify(self) -> list[str]:
        words = ["identify" if word == "diagnose" else word for word in self.words]
        for option in NOT_OF_IDENTIFY:
            while option in words:
                del words[words.index(option) : words.index(option) + 2]
        # an FMU takes places of joints and gravity from the file
        placed = [k for k, word in enumerate(words) if word.startswith(OF_THE_FILE)]
        for k in reversed(placed):
            del words[k - 1 : k + 1]
        return [word for word in words if word not in ("--json", "--isolability")]

    def again(self, *more: str, runs: Sequence[str] = ()) -> str:
        """The same command with more runs and more words at its end."""
        at = self.words.index("diagnose") + 1 if "diagnose" in self.words else len(self.words)
        return joined([*self.words[:at], *runs, *self.words[at:], *more])


def joined(words: Sequence[str]) -> str:
    """Words as a line for the shell; files that are all of a folder with the same beginning and
    ending are written as the pattern that they came from."""
    shown, rest = list[str](), list(words)
    while rest:
        pattern, count = _pattern(rest)
        shown.append(pattern if pattern else shlex.quote(rest[0]))
        del rest[:count]
    return " ".join(shown)


def _pattern(words: Sequence[str]) -> tuple[str, int]:
    """A pattern that is the first of these words and those behind it, and how many; "", 1: none."""
    first = Path(words[0])
    for count in range(len(words), MANY - 1, -1):
        start = _beginning([Path(word).stem for word in words[:count]])
        beginning = words[0].removesuffix(first.name) + start
        there = sorted(map(str, first.parent.glob(f"{start}*{first.suffix}")))
        plain = shlex.quote(beginning + first.suffix) == beginning + first.suffix
        if plain and there == [str(Path(word)) for word in words[:count]]:
            return f"{beginning}*{first.suffix}", count
    return "", 1


def shortened(words: Sequence[str]) -> str:
    """Words as one line to be read; of many files in a row how they begin, and how many they are:
    `run*.csv, 20 files`."""
    shown = list[str]()
    for (folder, ending), same in groupby(words, key=lambda word: _kind(Path(word))):
        alike = list(same)
        if ending and len(alike) >= MANY:
            start = _beginning([Path(word).stem for word in alike])
            shown.append(f"{Path(folder) / f'{start}*{ending}'}, {len(alike)} files")
        else:
            shown += [shlex.quote(word) for word in alike]
    return " ".join(shown)


def _beginning(names: Sequence[str]) -> str:
    """What all of them begin with."""
    letters = takewhile(lambda same: len(set(same)) == 1, zip(*names, strict=False))
    return "".join(same[0] for same in letters)


def _kind(path: Path) -> tuple[str, str]:
    return str(path.parent), path.suffix


def applicable(diagnosis: Diagnosis) -> bool:
    """Whether something was found that a machine file can hold: no payload on some runs, and no
    effect of the user's own that works with numbers alone."""
    kept = diagnosis.effects or [change for change in diagnosis.changed if not change.runs]
    return bool(kept) and diagnosis.verdict in APPLICABLE and not unbuilt(diagnosis)


def unbuilt(diagnosis: Diagnosis) -> str:
    """Why an effect of the user's own that was found cannot be built, or nothing."""
    for effect in (own_effect(e.origin, "--effect") for e in diagnosis.effects if e.origin):
        try:
            effect.refuse_unbuilt()
        except MachineError as error:
            return str(error)
    return ""


def next_steps(diagnosis: Diagnosis, invocation: Invocation) -> list[tuple[str, str]]:
    """What to do next: a sentence and the command for it, "" where there is none."""
    steps = [step for e in diagnosis.effects for step in _separate(e, invocation)]
    something = bool(diagnosis.effects or diagnosis.changed)
    if diagnosis.machine:
        steps.append(
            ("Run the loop with the new machine file:", f"flexhex run -m {diagnosis.machine}")
        )
    elif applicable(diagnosis) and invocation.base == "hexapod":
        what = (
            "Or add the best of them" if diagnosis.verdict == "ambiguous" else "Add what was found"
        )
        steps.append((f"{what} to a copy of the machine file:", invocation.again("--apply")))
    elif invocation.base == "hexapod" and (why := unbuilt(diagnosis)):
        steps.append((f"To add it to a machine file, mend your effect. {why}", ""))
    elif something and diagnosis.verdict in APPLICABLE and invocation.base != "hexapod":
        text = "Fit what was found with all parameters, as the next base and as feedforward:"
        steps.append((text, invocation.identify()))
    loads = [c.estimate for c in diagnosis.changed if c.runs]
    if mass := next((load for load in loads if load.unit == "kg"), None):
        text = f"Write the payload into the heads of its runs: `payload: {number(mass.value)} kg`."
        steps.append((text, ""))
    if something and not diagnosis.held_out:
        text = "Validate it on held-out runs of another trajectory:"
        steps.append((text, invocation.again("--held-out", "OTHER_RUN")))
    if diagnosis.verdict == "unknown" and ONE_TRAJECTORY in diagnosis.findings:
        text = "Record another trajectory, at least twice: one alone names nothing. Then:"
        steps.append((text, invocation.again(runs=("NEW_RUN_1", "NEW_RUN_2"))))
    elif diagnosis.verdict == "unknown":
        text = "Look at the residual maps in the report; write an effect for what they show"
        steps.append((f"{text} (docs/own-effect.md):", "flexhex init effect.py"))
    if diagnosis.verdict == "none" and _far(diagnosis.residual):
        text = "The values of the file leave much more than those that were fitted: take these:"
        steps.append((text, invocation.fit()))
    if diagnosis.verdict == "none":
        text = "To see which effects a planned experiment could reveal:"
        steps.append((text, "flexhex diagnose --isolability TRAJECTORY"))
    if diagnosis.verdict == "cannot tell" and not any(MEND in n for n in diagnosis.notes):
        text = "Measure two trajectories, each at least twice, every axis through its whole range"
        steps.append((f"{text} (docs/diagnose.md, What the data must have).", ""))
        if diagnosis.parameters:
            steps.append(("Until then, fit the parameters to these logs:", invocation.fit()))
    return steps


def _far(residual: Residual) -> bool:
    """Whether the file's own values leave much more on an axis than the parameters that were
    fitted."""
    with np.errstate(invalid="ignore"):
        return bool((residual.nominal > FAR * residual.before).any())


def _separate(effect: Named, invocation: Invocation) -> list[tuple[str, str]]:
    if not effect.rivals:
        return []
    names = listed([title(name) for name in (effect.id, *effect.rivals)])
    plan = library()[effect.id].experiment if effect.id in library() else "another experiment"
    if not (effect.experiment or "").endswith(".csv"):
        return [(f"To tell {names} apart, measure: {plan}.", "")]
    text = f"To tell {names} apart, run {effect.experiment} twice ({plan}), then:"
    return [(text, invocation.again(runs=("NEW_RUN_1", "NEW_RUN_2")))]


def best_of(effect: Named) -> str:
    """How the effect that would be added is called in a question."""
    text = f"{title(effect.id)} on {where(effect.axes)}"
    if effect.rivals:
        text += f" (the best of {1 + len(effect.rivals)} indistinguishable effects)"
    return text
