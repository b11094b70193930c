"""Generated C computes what CasADi's own C does, to the last bit, in pairs and without vectors."""

from __future__ import annotations

import ctypes
import importlib
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.fmugen.blocks import BLOCKS, Source
from flexhex.fmugen.codegen import casadi_source, straight_line
from flexhex.fmugen.compile import SMALL, compile_object, link_shared
from flexhex.fmugen.graph import CALLS, INFIX, PATTERNS, Graph
from flexhex.fmugen.lanes import Lanes
from flexhex.fmugen.straight import Body, body
from flexhex.fmus.common.errors import BuildError
from flexhex.fmus.common.machine_file import load_machine
from tests.conftest import MACHINE_FILE, OUT
from tests.effects.machines import everything

Array = NDArray[np.float64]
FORMS = {"vectors": (), "none": ("-DFLEXHEX_NO_VECTORS",)}
CASES = [
    *(("tflex.toml", block) for block in BLOCKS),
    *(("effects", block) for block in ("plant", "feedforward", "filter", "estimator")),
    ("tflex-actuators.toml", "plant"),
    ("truth", "plant"),
]


def equations(kind: str, block: str) -> Sequence[ca.Function]:
    """Functions of a block: of a machine file, with all effects, of the simulated real machine."""
    if kind == "truth":
        truth = MACHINE_FILE.with_name("tflex-truth.toml")
        return Source(block, load_machine(MACHINE_FILE), truth).functions()
    machine = everything() if kind == "effects" else load_machine(MACHINE_FILE.with_name(kind))
    module: Any = importlib.import_module(f"flexhex.fmus.{block}.equations")
    functions: Sequence[ca.Function] = module.functions(machine)
    return functions


def casadi_text(functions: Sequence[ca.Function], block: str) -> str:
    """C by CasADi's own generator, which knows of no pairs."""
    generator = ca.CodeGenerator("theirs.c", {"casadi_int": "int"})
    for function in functions:
        generator.add(straight_line(function, f"{function.name()}_sx"))
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        return Path(folder, "theirs.c").read_text(encoding="utf-8")


def compiled(text: str, flags: Sequence[str] = ()) -> ctypes.CDLL:
    """A library of C text."""
    with tempfile.TemporaryDirectory(dir=OUT) as folder:
        source = Path(folder) / "generated.c"
        source.write_text(text, encoding="utf-8")
        library = compile_object(source, "", Path(folder), (*SMALL, *flags))
        return ctypes.CDLL(str(link_shared([library], library.with_suffix(".so"))))


def call(library: ctypes.CDLL, function: ca.Function, values: Sequence[Array]) -> list[Array]:
    """Results of one call; what the function does not write stays NaN."""
    results = [np.full(function.numel_out(k), np.nan) for k in range(function.n_out())]

    def pointers(arrays: Sequence[Array]) -> Any:
        return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))

    getattr(library, f"{function.name()}_sx")(pointers(values), pointers(results), None, None, 0)
    return results


def differing(
    functions: Sequence[ca.Function],
    block: str,
    flags: Sequence[str],
    draw: Callable[[int], Array],
    times: int = 20,
) -> list[str]:
    """Functions whose results differ from CasADi's in a bit; a NaN equals a NaN."""
    ours = compiled(casadi_source(functions, block, block), flags)
    theirs, names = compiled(casadi_text(functions, block)), []
    for function in functions:
        for _ in range(times):
            values = [draw(function.numel_in(k)) for k in range(function.n_in())]
            pairs = zip(call(ours, function, values), call(theirs, function, values), strict=True)
            if not all(np.array_equal(a, b, equal_nan=True) for a, b in pairs):
                names.append(function.name())
                break
    return names


@pytest.fixture
def draw() -> Callable[[int], Array]:
    """Random inputs of a size."""
    generator = np.random.default_rng(5)
    return lambda size: generator.uniform(-1.5, 1.5, size)


@pytest.mark.sample(4)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("kind", "block"), CASES)
def test_blocks_have_the_bits_of_casadis_own_c(
    kind: str, block: str, form: str, draw: Callable[[int], Array]
) -> None:
    functions = equations(kind, block)
    assert differing(functions, block, FORMS[form], draw) == []


def test_comparison_sees_a_changed_bit(draw: Callable[[int], Array]) -> None:
    x = ca.SX.sym("x", 3)
    ours = compiled(casadi_source([ca.Function("toy_f", [x], [x * (1 / 3)])], "toy", "toy"))
    theirs = compiled(casadi_text([ca.Function("toy_f", [x], [x / 3])], "toy"))
    function = ca.Function("toy_f", [x], [x])
    values = [np.array([3.0, 5.0, 7.0])]
    assert not np.array_equal(call(ours, function, values), call(theirs, function, values))


@pytest.mark.parametrize("form", FORMS)
def test_every_operation_has_the_bits_of_casadis_own_c(form: str) -> None:
    """Each on its own results and in two places, so that those on pairs are used; zeros of both
    signs, infinities and NaN among the inputs."""
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 2)
    functions, named = [], {getattr(ca, n): n for n in dir(ca) if n.startswith("OP_")}
    for op in (*INFIX, *CALLS, *PATTERNS):
        results = []
        for k in range(2):
            value = x[k]
            for _ in range(5):
                try:
                    value = ca.SX.binary(op, value, y[k])
                except RuntimeError:
                    value = ca.SX.unary(op, value)
            results.append(value)
        function = ca.Function(f"toy_{named[op]}", [x, y], [ca.vertcat(*results)])
        functions.append(function)
        assert op not in (ca.OP_SUB, ca.OP_DIV, ca.OP_SQ) or written(function).pairs
    special = [0.0, -0.0, 1.0, -2.5, 0.3, np.inf, -np.inf, np.nan]
    generator = np.random.default_rng(6)

    def any_of(size: int) -> Array:
        return generator.choice(special, size)

    assert differing(functions, "toy", FORMS[form], any_of, times=200) == []
    assert len(functions) > 40


def test_an_operation_without_c_is_refused() -> None:
    x = ca.SX.sym("x")
    function = ca.Function("toy_f", [x], [ca.erfinv(x)])
    with pytest.raises(BuildError, match=r"toy_f.*OP_ERFINV cannot be written as C"):
        casadi_source([function], "toy", "toy")


def test_names_that_c_uses_are_left_to_it(draw: Callable[[int], Array]) -> None:
    names = ["w", "v0", "sin", "pair"]
    symbols = [ca.SX.sym(name, 2) for name in names]
    total = sum(symbols, ca.SX.zeros(2))
    function = ca.Function("toy_f", symbols, [ca.sin(total)], names, ["res"])
    assert differing([function], "toy", (), draw) == []


def written(function: ca.Function) -> Body:
    """Its statements."""
    line = straight_line(function, function.name())
    return body(Graph.of(line), line.name_in(), line.name_out())


@pytest.mark.parametrize(
    ("block", "name"),
    [("kinematics", "correct"), ("kinematics", "rates"), ("feedforward", "torque")],
)
def test_arms_are_computed_in_pairs(block: str, name: str) -> None:
    """What is alone: the platform's chain, and what a pair of arms does not share."""
    function = next(f for f in equations("tflex.toml", block) if f.name() == f"{block}_{name}")
    text = written(function)
    assert 2 * text.pairs > 10 * text.singles
    assert len(text.lines) < 0.65 * function.n_instructions()


def test_values_without_a_likeness_stay_alone() -> None:
    x = ca.SX.sym("x")
    text = written(ca.Function("f", [x], [(x + 1) * x - x / (2 + x)], ["x"], ["y"]))
    assert text.pairs == 0


def test_neither_of_a_pair_needs_the_other() -> None:
    """The powers of a polynomial are alike, each needs the one before."""
    x = ca.SX.sym("x")
    value = x
    for _ in range(6):
        value = value * x
    line = ca.Function("f", [x], [value])
    assert Lanes(Graph.of(line)).pair == {}


def test_pairing_finds_the_arms_again() -> None:
    """Two arms that share a platform: operand with operand, not crosswise."""
    q, e = ca.SX.sym("q", 6), ca.SX.sym("e")

    def arm(q: ca.SX, size: float) -> ca.SX:
        return (q[0] * q[1] - q[1] * q[2] * size) * e + q[2] * q[2]

    graph = Graph.of(ca.Function("f", [q, e], [arm(q[:3], 2.5), arm(q[3:], 3.5)]))
    pair = Lanes(graph).pair
    inputs = {node.args: k for k, node in enumerate(graph.nodes) if node.op == ca.OP_INPUT}
    assert all(pair[inputs[0, k]] == inputs[0, k + 3] for k in range(3))
    assert inputs[1, 0] not in pair
