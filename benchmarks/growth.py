"""How cost grows with parameters, loops and cores."""

from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np

from benchmarks.blocks import Instance, library
from benchmarks.clock import Rival, Timing, measure
from flexhex.fmugen.blocks import block_interface, step_file
from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.estimator.equations import row_width

COUNTS = (162, 300, 450, 600)


def wider(machine: Machine, n_p: int) -> tuple[Interface, list[ca.Function]]:
    """The estimator with n_p parameters: those beyond the machine's are more actuator terms,
    each in one row alone, as those of an effect of the drives are. Its regressor costs little:
    the inputs multiplied by constants; what grows is the filter."""
    known = block_interface("estimator", machine)
    n, own, narrow = machine.n_arms, known.constants["N_P"], row_width(machine)
    alone = (own - narrow) // (n - 1)  # what each row has for itself; the rest is shared by all
    shared, each = narrow - alone, alone + (n_p - own) // n
    width = shared + each
    columns = [
        [*range(shared), *range(shared + i * each, shared + (i + 1) * each)] for i in range(n)
    ]
    sizes = {v.name: n_p for v in known.variables if v.size == own}
    variables = tuple(_resized(v, sizes[v.name]) if v.name in sizes else v for v in known.variables)
    constants = {**known.constants, "N_P": n_p, "WIDTH": width}
    x, xd, xdd = (ca.SX.sym(name, constants["N_X"]) for name in ("x", "xd", "xdd"))
    chi = ca.SX.sym("chi", 114)
    weights = np.random.default_rng(1).uniform(0.1, 1.0, n * width)
    phi = ca.vertcat(*(chi[k % 114] * float(w) for k, w in enumerate(weights)))
    names = ["x", "xd", "xdd", "chi"]
    functions = [
        ca.Function("estimator_regressor", [x, xd, xdd, chi], [phi], names, ["phi"]),
        ca.Function(
            "estimator_columns", [], [ca.SX(np.ravel(columns).astype(float))], [], ["columns"]
        ),
    ]
    return dataclasses.replace(known, variables=variables, constants=constants), functions


def _resized(v: Variable, size: int) -> Variable:
    start = np.resize(np.array(v.starts), size)
    return dataclasses.replace(v, size=size, start=start, elements=(), units=())


def estimator(machine: Machine, n_p: int) -> Instance:
    """A started estimator with n_p parameters and random inputs."""
    interface, functions = wider(machine, n_p)
    path = library(interface, functions, step_file("estimator"))
    width = sum(v.count for v in interface.inputs)
    rows = np.random.default_rng(2).uniform(-1, 1, (50, width))
    return Instance(path, interface, rows, t_start=0.0)


def by_parameters(machine: Machine, rounds: int) -> list[Timing]:
    """K alone for each of COUNTS."""
    rivals = [Rival(str(n_p), estimator(machine, n_p).ticks) for n_p in COUNTS]
    return measure(rivals, rounds)
