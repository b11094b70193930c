"""An SX function as a graph: one node for each value, after those that it is computed from."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.errors import BuildError

INFIX = {
    ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/", ca.OP_LT: "<", ca.OP_LE: "<=",
    ca.OP_EQ: "==", ca.OP_NE: "!=", ca.OP_AND: "&&", ca.OP_OR: "||",
}  # fmt: skip
"""Operations of two values that C writes between them."""
_LIBRARY = (
    "sqrt", "exp", "log", "log1p", "expm1", "sin", "cos", "tan", "asin", "acos", "atan", "sinh",
    "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "floor", "ceil", "fabs", "pow", "fmod",
    "remainder", "atan2", "hypot", "fmin", "fmax", "copysign",
)  # fmt: skip
CALLS: dict[int, str] = {getattr(ca, f"OP_{name.upper()}"): name for name in _LIBRARY}
CALLS |= {ca.OP_CONSTPOW: "pow", ca.OP_SIGN: "SIGN"}
"""Operations that are functions of C's library, or of pair.h."""
PATTERNS = {
    ca.OP_ASSIGN: "{0}", ca.OP_LIFT: "{0}", ca.OP_NEG: "-{0}", ca.OP_NOT: "!{0}",
    ca.OP_SQ: "{0} * {0}", ca.OP_TWICE: "2.0 * {0}", ca.OP_INV: "1.0 / {0}",
    ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0.0",
}  # fmt: skip
"""The others."""
COMMUTATIVE = (ca.OP_ADD, ca.OP_MUL)


@dataclass(frozen=True)
class Node:
    """A value: operation `op` of CasADi on the nodes `args`; of an input, args are its place
    (argument, element); of a constant, `value` is it."""

    op: int
    args: tuple[int, ...]
    value: float = 0.0

    @property
    def operands(self) -> tuple[int, ...]:
        """Nodes that this one is computed from."""
        return () if self.op in (ca.OP_INPUT, ca.OP_CONST) else self.args


@dataclass(frozen=True)
class Graph:
    """nodes in an order in which they can be computed; outputs (result, element, node)."""

    nodes: list[Node]
    outputs: list[tuple[int, int, int]]

    @staticmethod
    def of(function: ca.Function) -> Graph:
        """Graph of an SX function; BuildError for an operation that has no C here."""
        nodes: list[Node] = []
        outputs: list[tuple[int, int, int]] = []
        at: dict[int, int] = {}  # CasADi's place of a value -> node
        constants: dict[str, int] = {}
        for k in range(function.n_instructions()):
            op, ins = function.instruction_id(k), function.instruction_input(k)
            outs = function.instruction_output(k)
            if op == ca.OP_OUTPUT:
                outputs.append((outs[0], outs[1], at[ins[0]]))
                continue
            if op == ca.OP_CONST:
                value = function.instruction_constant(k)
                at[outs[0]] = constants.setdefault(repr(value), len(nodes))
                if at[outs[0]] == len(nodes):
                    nodes.append(Node(op, (), value))
                continue
            _check(op, function)
            at[outs[0]], args = len(nodes), ins if op == ca.OP_INPUT else [at[i] for i in ins]
            nodes.append(Node(op, tuple(args)))
        return Graph(nodes, outputs)


def _check(op: int, function: ca.Function) -> None:
    if op == ca.OP_INPUT or op in INFIX or op in CALLS or op in PATTERNS:
        return
    named = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
    raise BuildError(
        f"{function.name()}: CasADi's {named[op]} cannot be written as C; compute it from"
        " sums, products, roots and functions of C's library"
    )
