"""Results as the Python interface gives them: records that show themselves, in a notebook, too."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from flexhex.diagnosis.estimation import excitation, records
from flexhex.diagnosis.result import verdict
from flexhex.output.parts import Part, Sentence, Shown

T = TypeVar("T")


class Diagnosis(Shown, verdict.Diagnosis):
    __doc__ = verdict.Diagnosis.__doc__

    def parts(self) -> Iterable[Part]:
        """What `flexhex diagnose` prints."""
        from flexhex.diagnose.titles import readable
        from flexhex.diagnose.view import diagnosis_parts

        findings = [Sentence(f"finding: {readable(text)}") for text in self.findings]
        return [*diagnosis_parts(self), *findings]


class Identified(Shown, records.Identified):
    __doc__ = records.Identified.__doc__

    def parts(self) -> Iterable[Part]:
        """What `flexhex identify` prints."""
        from flexhex.identify.other import Pointers, identified_parts

        rest = Pointers("all are in .parameters", "their .name is whole")

        return identified_parts(self, rest=rest)


class Excitation(Shown, excitation.Excitation):
    __doc__ = excitation.Excitation.__doc__

    def parts(self) -> Iterable[Part]:
        """What it is expected to narrow most."""
        from flexhex.identify.other import excitation_parts

        return excitation_parts(self)


@dataclass(frozen=True, repr=False)
class Written(Shown):
    """Files that were written, and what who uses them must know."""

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()

    def parts(self) -> Iterable[Part]:
        """A line for each of them."""
        files = [Sentence(f"written  {path}") for path in self.files]
        return [*files, *(Sentence(f"note: {text}") for text in self.notes)]


def shown(kind: type[T], record: object) -> T:
    """A record as one of a kind that shows itself, with the same fields."""
    return kind(**vars(record))
