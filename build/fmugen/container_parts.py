"""What a container is made of: parts (FMUs of ours), links between them, its own variables."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from flexhex.fmugen.described import interface_of
from flexhex.fmugen.fmu import CONFIG, FMI_HEADERS, RUNTIME
from flexhex.fmugen.sources import variables
from flexhex.fmus.common.archive import open_zip
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface, Item, Variable

NAME = "controller"


@dataclass(frozen=True)
class ContainedFmu:
    """One FMU in the container: instance name and the bytes of an .fmu made by fmugen."""

    name: str
    fmu: bytes

    @cached_property
    def interface(self) -> Interface:
        """Its variables. InterfaceError for an FMU of another maker."""
        with open_zip(self.fmu, self.name) as archive:
            return interface_of(archive.read("modelDescription.xml"), self.name)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Parameters, inputs and outputs in value-reference order."""
        return variables(self.interface)

    @cached_property
    def texts(self) -> dict[str, str]:
        """Sources of the FMU's folder alone, without the adapter and the table of variables.

        Headers wear the FMU's name, since several FMUs have an effects.h.
        """
        name = self.interface.name
        shared = {p.name for p in RUNTIME.glob("*.[ch]")} | {*FMI_HEADERS, CONFIG}
        with open_zip(self.fmu, self.name) as archive:
            texts = {
                file.removeprefix("sources/"): archive.read(file).decode()
                for file in archive.namelist()
                if file.startswith("sources/") and file.endswith((".c", ".h"))
            }
        own = {f: t for f, t in texts.items() if f not in shared and f != f"{name}_fmu.c"}
        if f"{name}_step.c" not in own:
            raise InterfaceError(f"{self.name}: its FMU holds no {name}_step.c: build it anew")
        for header in [file for file in own if file.endswith(".h")]:
            renamed = f"{name}_{header}"
            own[renamed] = own.pop(header)
            own = {
                file: text.replace(f'#include "{header}"', f'#include "{renamed}"')
                for file, text in own.items()
            }
        return {file: _renamed(text, name) for file, text in own.items()}


def _renamed(text: str, name: str) -> str:
    """Sources whose symbols wear the container's name too, so that the FMU itself links beside."""
    text = re.sub(rf"\b({name}_(?:casadi_\w*|\w+_sx))", rf"{NAME}_\1", text)
    own_block = f"#define {name}_block {NAME}_{name}_block\n"
    return text.replace('#include "block.h"\n', f'#include "block.h"\n\n{own_block}', 1)


@dataclass(frozen=True)
class Link:
    """One scalar connection. part None: the variable is the container's own."""

    source: str | None
    output: str
    target: str | None
    input: str


@dataclass(frozen=True)
class Container:
    """Parts and what connects them; every input of a part has exactly one link.

    inputs: the container's, whose min and max are narrowed to what the parts allow. outputs:
    the container's by name -> (part, variable), a whole array or a scalar.
    """

    parts: tuple[ContainedFmu, ...]
    links: tuple[Link, ...]
    inputs: tuple[Variable, ...]
    outputs: Mapping[str, tuple[str, str]]
    description: str
    base: float

    def part(self, name: str) -> ContainedFmu:
        """The part of that name."""
        return next(p for p in self.parts if p.name == name)

    @cached_property
    def interface(self) -> Interface:
        """Of the container: parameters `<part>_<parameter>`, inputs, outputs."""
        parameters = [
            dataclasses.replace(v, name=f"{part.name}_{v.name}", description=f"{part.name}: {text}")
            for part in self.parts
            for v, text in ((v, v.description) for v in part.interface.parameters)
        ]
        outputs = [self._output(name, *origin) for name, origin in self.outputs.items()]
        listed = (*parameters, *self.inputs, *outputs)
        return Interface(NAME, self.description, self.base, listed, faults=self._faults)

    @property
    def _faults(self) -> tuple[Item, ...]:
        """What the faults of all parts mean, code by code; the highest is shown."""
        named = [[f"{p.name}: {i.description}" for i in p.interface.faults] for p in self.parts]
        codes = enumerate(itertools.zip_longest(*named), start=2)
        return tuple(Item(f"fault_{k}", ", ".join(t for t in texts if t)) for k, texts in codes)

    def _output(self, name: str, part: str, variable: str) -> Variable:
        listed = self.part(part).interface.outputs
        output = next(v for v in listed if v.name == variable)
        sources = tuple(f"{part}_{source}" for source in output.initial_from)
        text = f"{part}: {output.description}"
        return dataclasses.replace(output, name=name, description=text, initial_from=sources)
