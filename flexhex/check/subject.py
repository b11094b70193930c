"""An FMU file as the checks see it: the archive's names and the parsed description."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from lxml import etree

from flexhex.fmus.common.archive import open_zip
from flexhex.fmus.common.errors import InterfaceError


def parsed(text: str | None, otherwise: float = math.nan) -> float:
    """The number that an attribute holds; `otherwise` without the attribute, nan for nonsense."""
    if text is None:
        return otherwise
    try:
        return float(text)
    except ValueError:
        return math.nan


SSD, XML = "SystemStructure.ssd", "modelDescription.xml"


@dataclass(frozen=True)
class Scalar:
    """One ScalarVariable; index counts from 1, attributes are those of its type's element."""

    index: int
    name: str
    reference: str
    kind: str
    causality: str
    variability: str
    initial: str
    attributes: dict[str, str]

    def number(self, key: str, otherwise: float = math.nan) -> float:
        """A numeric attribute such as `min`, 0 or 1 of a Boolean; nan when it is no number."""
        text = self.attributes.get(key)
        if self.kind == "Boolean" and text in ("true", "false"):
            return float(text == "true")
        return parsed(text, otherwise)


@dataclass(frozen=True)
class Subject:
    """An FMU file that is checked: names of the archive in its order, the parsed description."""

    path: Path
    names: tuple[str, ...]
    root: etree._Element

    @staticmethod
    def open(path: Path) -> Subject:
        """InterfaceError when it is no archive with a readable modelDescription.xml."""
        try:
            with open_zip(path, str(path)) as archive:
                names = tuple(archive.namelist())
                damaged = archive.testzip()
                if damaged is not None:
                    raise InterfaceError(f"{path}: {damaged} is damaged in the archive")
                root = etree.fromstring(archive.read(XML))
        except KeyError:
            other = " (a system description? an FMU is wanted)" if SSD in names else ""
            raise InterfaceError(f"{path}: {XML} is missing{other}") from None
        except etree.XMLSyntaxError as error:
            raise InterfaceError(f"{path}: {XML}: {error}") from None
        except (RuntimeError, zipfile.BadZipFile, zlib.error, ValueError, OSError) as error:
            # encrypted, damaged, or packed in a way that Python does not know
            raise InterfaceError(f"{path}: cannot be unpacked ({error})") from None
        return Subject(path, names, root)

    def archive(self) -> zipfile.ZipFile:
        """The archive, to unpack it."""
        return open_zip(self.path, str(self.path))

    def read(self, name: str) -> bytes:
        """One file of the archive."""
        with self.archive() as archive:
            return archive.read(name)

    def items(self, v: Scalar) -> tuple[float, ...]:
        """Values of an enumeration's items; 0 alone where its type has none."""
        items = (
            parsed(item.get("value"))
            for simple in self.root.iterfind("TypeDefinitions/SimpleType")
            if simple.get("name") == v.attributes.get("declaredType")
            for item in simple.iterfind("Enumeration/Item")
        )
        return tuple(value for value in items if math.isfinite(value)) or (0.0,)

    @property
    def cosimulation(self) -> etree._Element | None:
        """The element CoSimulation."""
        return self.root.find("CoSimulation")

    @property
    def ours(self) -> bool:
        """True for an FMU of flexhex, of which more is demanded than the standard does."""
        return str(self.root.get("generationTool")).partition(" ")[0] == "flexhex"

    @cached_property
    def variables(self) -> tuple[Scalar, ...]:
        """All scalar variables, defaults of the standard filled in."""
        return tuple(self._scalars())

    def _scalars(self) -> Iterator[Scalar]:
        for k, element in enumerate(self.root.iterfind("ModelVariables/ScalarVariable"), 1):
            typed = next((e for e in element if e.tag != "Annotations"), None)
            causality = element.get("causality", "local")
            default = "exact" if causality in ("parameter", "input") else "calculated"
            yield Scalar(
                k,
                element.get("name", ""),
                element.get("valueReference", ""),
                "" if typed is None else str(typed.tag),
                causality,
                element.get("variability", "continuous"),
                element.get("initial", default),
                {} if typed is None else {str(k): str(v) for k, v in typed.attrib.items()},
            )
