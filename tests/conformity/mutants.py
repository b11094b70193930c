"""Mistakes that an FMU can have: how each is made, what must be said.

The FMU is the test block of tests/adapter (a gain and an integrator).
"""

from __future__ import annotations

import re

from tests.conformity.archives import XML, Files, passage_out, text, without
from tests.conformity.mutants_binary import BINARY
from tests.conformity.mutations import Mutants, add, cut, move

SO = "binaries/linux64/toy.so"


def other_sources(files: Files) -> None:
    """The GUID of the description stands in no source any more."""
    match = re.search(rb'guid="([^"]+)"', files[XML])
    assert match is not None
    for name in [n for n in files if n.startswith("sources/")]:
        files[name] = files[name].replace(match[1], b"{another}")


def other_machine(files: Files) -> None:
    """The library says that it is for ARM."""
    files[SO] = files[SO][:18] + b"\xb7\x00" + files[SO][20:]


def exchanged(files: Files) -> None:
    """The references of two outputs of one kind."""
    for old, new in (("11", "x"), ("15", "11"), ("x", "15")):
        text(f'valueReference="{old}"', f'valueReference="{new}"')(files)


def utf16(files: Files) -> None:
    """The description in another encoding, which XML allows."""
    files[XML] = files[XML].decode().replace("UTF-8", "UTF-16").encode("utf-16")


def other_results(files: Files) -> None:
    """One of the results that it carries, the last number."""
    name = "resources/reference_out.csv"
    rows = files[name].decode().splitlines()
    cells = rows[-1].split(",")
    cells[1] = str(float(cells[1]) + 1e-3)
    files[name] = "\n".join([*rows[:-1], ",".join(cells), ""]).encode()


ARCHIVE: Mutants = {
    "source that does not compile": (
        text("#include", "#error stop\n#include", "sources/states.c"),
        r"sources/states.c does not compile: states.c:\d+:\d+: error: #error stop$",
    ),
    "results of another build": (other_results, r"y is off by 0\.001 at [0-9.]+ s from what"),
    "source file listed but missing": (without("sources/states.c"), "listed in SourceFiles but"),
    "source file not listed": (text('<File name="states.c"/>', ""), "not listed in SourceFiles"),
    "header missing": (without("sources/instance.h"), "included but missing"),
    "sources of another build": (other_sources, "of another build"),
    "binary missing": (without(SO), "brings a binary"),
    "binary of another name": (move(SO, "binaries/linux64/other.so"), "as modelIdentifier says"),
    "binary of another machine": (other_machine, "is no linux64 library"),
    "binary truncated": (cut(SO, 0.3), "cannot be loaded|crashes"),
    "unknown platform": (move(SO, "binaries/amiga/toy.so"), "not the name of a platform"),
    "description missing": (without(XML), "modelDescription.xml"),
    "documentation missing": (without("documentation/index.html"), "index.html is missing"),
    "licence missing": (without("documentation/licenses/license.txt"), "license.txt is missing"),
    "picture damaged": (cut("model.png", 0.5), "no complete PNG"),
    "file without a place": (add("notes.txt", b"x"), "no place in an FMU"),
    "path outside the archive": (add("resources/../../x", b"x"), "not a path inside"),
}
VARIABLES: Mutants = {
    "min above max": (text('min="-1.0" max="1.0"', 'min="2.0" max="1.0"'), "min = 2 is above"),
    "start outside": (text('start="2.0"', 'start="20.0"'), "start = 20, outside 0 to 9"),
    "start is no number": (text('start="2.0"', 'start="INF"'), "no finite number"),
    "start missing": (text(' start="2.0"', ""), "gain: has no start value"),
    "start of a calculated output": (
        text(
            'initial="calculated">\n      <Real unit="rad"',
            'initial="calculated">\n      <Real start="0" unit="rad"',
        ),
        "although it is calculated",
    ),
    "variable twice": (text('name="last"', 'name="y"'), "variable y is declared 2 times"),
    "two inputs share a reference": (
        text('name="a[1]" valueReference="7"', 'name="a[1]" valueReference="6"'),
        "share value reference",
    ),
    "input that is fixed": (
        text('causality="input" variability="discrete"', 'causality="input" variability="fixed"'),
        "input with variability fixed",
    ),
    "unit undefined": (text('unit="N m"', 'unit="N km"'), "not among the UnitDefinitions"),
    "unit defined as another": (
        text('<BaseUnit kg="1" m="2" s="-2"/>', '<BaseUnit kg="1" m="1" s="-2"/>'),
        "unit N m is defined as something else",
    ),
    "display unit of another unit": (
        text('displayUnit="deg"', 'displayUnit="mm"'),
        "does not belong to unit",
    ),
    "sample time that does not fit": (
        text('start="0.0005"', 'start="0.0006"'),
        "2.4 steps of 0.00025 s: not whole",
    ),
    "display unit of another size": (
        text('name="mN m" factor="1000.0"', 'name="mN m" factor="1"'),
        "unit N m: 1 N m is 1000 mN m, not 1$",
    ),
    "name that is not structured": (
        text('name="begin[2]"', 'name="begin 2"'),
        "'begin 2' is no structured name",
    ),
    "minimum below what is taken": (
        text('min="1e-06" max="10.0" start="0.0005"', 'min="1e-09" max="10.0" start="0.0005"'),
        "Ts = 1e-09, its min, is refused",
    ),
    "maximum below what is taken": (
        text('min="0.0" max="9.0"', 'min="0.0" max="8.0"'),
        "gain = 8.00000000000000[12][0-9]* is taken, declared max 8$",
    ),
    "fixed parameter declared tunable": (
        text(
            'to y" causality="parameter" variability="fixed"',
            'to y" causality="parameter" variability="tunable"',
        ),
        "offset is tunable, but cannot be set while it runs",
    ),
    "tunable parameter declared fixed": (
        text('variability="tunable"', 'variability="fixed"'),
        "gain is fixed, but can be set while it runs$",
    ),
    "input declared as a fixed parameter": (
        text('input" variability="discrete"', 'parameter" variability="fixed"'),
        "u is fixed, but can be set while it runs$",
    ),
    "input declared as a tunable parameter": (
        text(
            'causality="input" variability="discrete"',
            'causality="parameter" variability="tunable"',
        ),
        "u is an input in one of resources/reference_in.csv and the description, not in both",
    ),
    "two outputs exchanged": (exchanged, "last is off by|ticks is off by"),
    "written in UTF-16": (utf16, "modelDescription.xml is written in UTF-16, FMI 2.0 wants UTF-8"),
    "no FMI version": (text('fmiVersion="2.0" ', ""), "has no fmiVersion: not the description"),
    "reference missing": (text(' valueReference="11"', ""), "last has no valueReference$"),
    "reference that the binary lacks": (
        text('name="fault" valueReference="16"', 'name="fault" valueReference="77"'),
        "fault cannot be read .fmi2GetInteger: value reference 77 does not exist",
    ),
    "two outputs share a reference": (
        text('name="last" valueReference="11"', 'name="last" valueReference="10"'),
        "y shares value reference 10 with last$",
    ),
    "item twice": (text('name="wide"', 'name="none"'), "2 items have the name 'none'"),
    "item without a name": (text('name="wide"', 'name=""'), "1 items have the name ''"),
    "nominal negative": (text('nominal="', 'nominal="-'), "nominal = -"),
    "terminal without variable": (
        text(
            'variableName="a[1]"', 'variableName="b[1]"', "terminalsAndIcons/terminalsAndIcons.xml"
        ),
        "has no variable b",
    ),
}
STRUCTURE: Mutants = {
    "no kind of FMU": (
        passage_out("<CoSimulation ", "</CoSimulation>"),
        "no element CoSimulation: nothing can be run",
    ),
    "guid empty": (text('guid="{', 'guid="" x="{'), "guid is empty"),
    "output not listed": (
        text('<Unknown index="11" dependencies=""/>', ""),
        "output y is missing in ModelStructure/Outputs",
    ),
    "input listed as output": (
        text('<Unknown index="11" dependencies=""/>', '<Unknown index="6" dependencies=""/>'),
        "index 6, which is no output",
    ),
    "dependency that does not exist": (
        text('index="11" dependencies=""', 'index="11" dependencies="99"'),
        "y depends on index 99",
    ),
    "dependencies out of order": (
        text('index="11" dependencies=""', 'index="11" dependencies="7 6"'),
        "not in ascending order",
    ),
    "step size zero": (text('stepSize="0.00025"', 'stepSize="0"'), "stepSize = 0"),
    "serialises without states": (
        text('canGetAndSetFMUstate="true"', 'canGetAndSetFMUstate="false"'),
        "canSerializeFMUstate without",
    ),
    "log category undeclared": (
        text('<Category name="logEvents"', '<Category name="logOther"'),
        "not those of this adapter",
    ),
    "needs a tool": (
        text('needsExecutionTool="false"', 'needsExecutionTool="true"'),
        "needs no tool",
    ),
}
FMU = {**ARCHIVE, **VARIABLES, **STRUCTURE, **BINARY}
