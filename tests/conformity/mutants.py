"""Mistakes that an FMU or a system description can have: how each is made, what must be said.

The FMU is the test room of tests/adapter (a gain and an integrator), the .ssp the hexapod's.
"""

from __future__ import annotations

import re

from tests.conformity.archives import XML, Change, Files, passage_out, rebuilt, text, without

SO = "binaries/linux64/toy.so"
SSD = "SystemStructure.ssd"
Mutants = dict[str, tuple[Change, str]]


def add(name: str, data: bytes) -> Change:
    """Put a further file into the archive."""

    def change(files: Files) -> None:
        files[name] = data

    return change


def move(old: str, new: str) -> Change:
    """Rename a member."""

    def change(files: Files) -> None:
        files[new] = files.pop(old)

    return change


def cut(member: str, share: float) -> Change:
    """Keep the first part of a member."""

    def change(files: Files) -> None:
        files[member] = files[member][: int(share * len(files[member]))]

    return change


def other_sources(files: Files) -> None:
    """The GUID of the description stands in no source any more."""
    found = re.search(rb'guid="([^"]+)"', files[XML])
    assert found is not None
    for name in [n for n in files if n.startswith("sources/")]:
        files[name] = files[name].replace(found[1], b"{another}")


def other_machine(files: Files) -> None:
    """The library says that it is for ARM."""
    files[SO] = files[SO][:18] + b"\xb7\x00" + files[SO][20:]


ARCHIVE: Mutants = {
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
    "nominal negative": (text('nominal="', 'nominal="-'), "nominal = -"),
    "terminal without variable": (
        text(
            'variableName="a[1]"', 'variableName="b[1]"', "terminalsAndIcons/terminalsAndIcons.xml"
        ),
        "has no variable b",
    ),
}

STRUCTURE: Mutants = {
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

BINARY: Mutants = {
    "guid of another build": (text('guid="{', 'guid="{0'), "refuses to be instantiated"),
    "any guid taken": (
        rebuilt("fmi2.c", "strcmp(guid, FLEXHEX_MODEL.guid) != 0", "0"),
        "takes any GUID",
    ),
    "false: directional derivative": (
        text('providesDirectionalDerivative="false"', 'providesDirectionalDerivative="true"'),
        "providesDirectionalDerivative is promised",
    ),
    "false: interpolates inputs": (
        text('canInterpolateInputs="false"', 'canInterpolateInputs="true"'),
        "canInterpolateInputs is promised",
    ),
    "false: output derivatives": (
        text('maxOutputDerivativeOrder="0"', 'maxOutputDerivativeOrder="1"'),
        "maxOutputDerivativeOrder is promised",
    ),
    "false: runs asynchronously": (
        text('canRunAsynchronuously="false"', 'canRunAsynchronuously="true"'),
        "canRunAsynchronuously is true",
    ),
    "false: ignores the importer's memory": (
        text('MemoryManagementFunctions="false"', 'MemoryManagementFunctions="true"'),
        "but it uses them",
    ),
    "false: states": (
        rebuilt("states.c", "memcpy(m->head, s + 1, m->block_size);", ""),
        "a state does not bring everything back",
    ),
    "false: serialises": (
        rebuilt(
            "states.c", "memcpy(s + 1, serializedState + sizeof(envelope), m->block_size);", ""
        ),
        "bytes do not bring everything back",
    ),
    "damaged bytes taken": (
        rebuilt("states.c", "return memcmp(&e, &wanted, sizeof e) == 0 ? NULL", "return 1 ? NULL"),
        "damaged bytes of a state are taken",
    ),
    "false: several instances": (
        rebuilt(
            "fmi2.c",
            "index_variables(m);",
            "static int n; if (n++ % 2) { return NULL; } index_variables(m);",
        ),
        "second instance is refused",
    ),
    "instances share memory": (
        rebuilt(
            "toy_step.c",
            "state *s = memory;\n  double next",
            "static state one; state *s = &one; (void)memory;\n  double next",
        ),
        "not bring everything back|runs otherwise",
    ),
    "reset keeps something": (
        rebuilt(
            "fmi2.c",
            'flexhex_log(m, fmi2OK, FLEXHEX_EVENTS, "reset");\n  make_fresh(m);',
            "m->head->phase = FLEXHEX_INSTANTIATED;",
        ),
        "after fmi2Reset",
    ),
    "starts of another build": (
        text('start="0.5"', 'start="0.25"'),
        "starts at 0.5 in the binary, 0.25 declared",
    ),
    "hidden dependency on an input": (
        rebuilt(
            "values.c",
            "m->values + vr[0], value, nvr * sizeof *value);",
            "m->values + vr[0], value, nvr * sizeof *value); if (vr[0] == 6) {"
            " m->values[10] += value[0]; }",
        ),
        r"y depends on u, ModelStructure",
    ),
    "hidden dependency of a first output": (
        text('<Unknown index="11" dependencies="2"/>', '<Unknown index="11" dependencies=""/>'),
        "the first y depends on offset",
    ),
    "version of another standard": (
        rebuilt("fmi2.c", "return fmi2Version;", 'return "1.0";'),
        "the binary says FMI",
    ),
    "function missing": (
        rebuilt("advance.c", "fmi2Status fmi2CancelStep", "fmi2Status other_CancelStep"),
        "lacks fmi2CancelStep|cannot be loaded",
    ),
    "crash": (
        rebuilt("advance.c", "advance(m, end);", "advance(m, end); *(volatile int *)0 = 1;"),
        "crashes",
    ),
    "step that changes a category": (
        rebuilt("messages.c", '"logEvents"};', '"logOther"};'),
        "logEvents is declared, but cannot be switched on",
    ),
    "values out of range taken": (
        rebuilt("values.c", "if (!(value[k] >= low && value[k] <= high)) {", "if (0) {"),
        "is taken, declared",
    ),
    "refusal without fault": (
        rebuilt("messages.c", "m->values[m->n_values - 1] = 1.0;", ""),
        "fault does not show it",
    ),
    "output outside its range": (
        rebuilt("toy_step.c", "y->ticks = s->ticks;", "y->ticks = -1.0;"),
        "ticks = -1, declared 0 to inf",
    ),
}

SYSTEM: Mutants = {
    "input unfed": (
        passage_out(
            '<ssd:Connection startElement="reference" startConnector="payload" endElement="plant"',
            "</ssd:Connection>",
            SSD,
        ),
        "plant.payload: fed by nothing",
    ),
    "unit of a connector": (
        text('<ssc:Real unit="rad/s2"/>', '<ssc:Real unit="rad/s"/>', SSD),
        "unit rad/s in the system, rad/s2 in the FMU",
    ),
    "units at the ends of a wire": (
        text(
            'startConnector="r[1]" endElement="feedback"',
            'startConnector="rd[1]" endElement="feedback"',
            SSD,
        ),
        "rad/s into rad",
    ),
    "output and input exchanged": (
        text(
            '<ssd:Connector name="r[1]" kind="output">',
            '<ssd:Connector name="r[1]" kind="input">',
            SSD,
        ),
        "input in the system, output in the FMU",
    ),
    "connector that the FMU lacks": (
        text('<ssd:Connector name="rd[3]"', '<ssd:Connector name="rd[9]"', SSD),
        "no such variable",
    ),
    "connector twice": (
        text('<ssd:Connector name="rd[3]"', '<ssd:Connector name="rd[2]"', SSD),
        "2 connectors of that name",
    ),
    "importers told different steps": (
        text('fixedStepSize="0.00025"', 'fixedStepSize="0.0005"', SSD),
        "steps by 0.0005 s",
    ),
    "sample time that is not whole": (
        text(
            '<ssv:Real value="0.0005" unit="s"/>',
            '<ssv:Real value="0.0006" unit="s"/>',
            "resources/F.ssv",
        ),
        "2.4 base steps",
    ),
    "parameter out of range": (
        text(
            'name="corrections">\n      <ssv:Real value="1.0"',
            'name="corrections">\n      <ssv:Real value="99.0"',
            "resources/N_F.ssv",
        ),
        "N_F.corrections = 99",
    ),
    "parameter that the FMU lacks": (
        text('name="corrections"', 'name="correction"', "resources/N_F.ssv"),
        "is set, but the FMU has no such",
    ),
    "wire to nowhere": (
        text(
            'endElement="N_F" endConnector="theta[2]"',
            'endElement="N_F" endConnector="phi[2]"',
            SSD,
        ),
        "no variable 'phi",
    ),
    "wired twice": (
        text(
            'endElement="N_F" endConnector="theta[2]"',
            'endElement="N_F" endConnector="theta[1]"',
            SSD,
        ),
        "is fed by",
    ),
    "FMU missing": (without("resources/filter.fmu"), "filter.fmu is missing"),
    "element without a place": (
        text("<ssd:Connections>", "<ssd:Nonsense/><ssd:Connections>", SSD),
        "Nonsense",
    ),
}
FMU = {**ARCHIVE, **VARIABLES, **STRUCTURE, **BINARY}
