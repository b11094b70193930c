"""Mistakes of a binary: promises of its description that it does not keep."""

from __future__ import annotations

from tests.conformity.archives import rebuilt, text
from tests.conformity.mutations import Mutants

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
            "state *s = (state *)memory;\n  double next",
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
            "m->values + vr[0], array, nvr * sizeof *m->values);",
            "m->values + vr[0], array, nvr * sizeof *m->values); if (vr[0] == 6) {"
            " m->values[10] += element(type, array, 0); }",
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
        rebuilt("values.c", "if (!(value >= low && value <= high)) {", "if (0) {"),
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
