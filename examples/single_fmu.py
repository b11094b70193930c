"""One FMU alone in FMPy: no flexhex needed, as for any other FMU.

    python examples/single_fmu.py out/fmus/reference.fmu t_start=0.1 kind=chirp
    python examples/single_fmu.py out/fmus/plant.fmu 'tau[1]=0.5' --stop 0.05

Sets parameters and constant inputs by name, runs it at its own step size and prints the
outputs at eleven instants.
"""

from __future__ import annotations

import argparse

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.model_description import ScalarVariable


def number(variable: ScalarVariable, text: str) -> float:
    """The value of a text: a number, true, false, or the name of an enumeration's item."""
    if variable.type == "Enumeration":
        items = {item.name: item.value for item in variable.declaredType.items}
        return int(items.get(text, text))
    flags = {"true": 1, "false": 0}
    return float(flags.get(text, text) if variable.type == "Boolean" else text)


def main() -> None:
    parser = argparse.ArgumentParser(description="Run one FMU in FMPy.")
    parser.add_argument("fmu", help="path of the .fmu file")
    parser.add_argument(
        "values", nargs="*", default=[], metavar="name=value", help="parameters and inputs"
    )
    parser.add_argument("--stop", type=float, default=1.0, help="seconds to simulate")
    parser.add_argument("--show", type=int, default=8, help="outputs to print")
    arguments = parser.parse_args()

    try:
        description = read_model_description(arguments.fmu)
    except Exception as error:  # FMPy raises whatever it meets
        parser.error(f"{arguments.fmu} is no readable FMU: {error}")
    step = description.defaultExperiment.stepSize
    variables = {v.name: v for v in description.modelVariables}
    values = {}
    for pair in arguments.values:
        name, equals, text = pair.rpartition("=")
        if not equals or name not in variables:
            parser.error(f"{pair}: wants name=value, with a name of {description.modelName}")
        try:
            values[name] = number(variables[name], text)
        except ValueError:
            parser.error(f"{pair}: no value of {name}, which is of type {variables[name].type}")
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    result = simulate_fmu(
        arguments.fmu,
        stop_time=arguments.stop,
        step_size=float(step),
        output_interval=float(step),
        start_values=values,
        output=outputs,
    )
    shown = outputs[: arguments.show]
    print(f"{description.modelName}: {description.description}, {len(outputs)} outputs")
    print("  ".join(["time [s]".rjust(10), *(name.rjust(14) for name in shown)]))
    for k in np.linspace(0, len(result) - 1, 11).astype(int):
        row = [f"{result['time'][k]:10.5f}", *(f"{result[name][k]:14.6g}" for name in shown)]
        print("  ".join(row))


if __name__ == "__main__":
    main()
