"""Toy blocks that show how time passes: a source that stamps its origin and a relay.

The source's r[1] is the base step at which it becomes visible, r[2] a wave. The relay hands
the stamp on (y[1] = u[1]) and mixes the wave with its own past and a second input (y[2]),
so that any change of order or of a bit shows. Both have initial outputs that are not zero.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path

from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.common.interface import Interface, Item, Variable
from flexhex.ssp.system import BASE_STEP, Component, System
from flexhex.ssp.write import write_ssp
from tests.conftest import OBJECTS

SOURCE_C = """#include <math.h>
#include <string.h>

#include "source.h"

typedef struct {
  double k;
} state;

static bool start(const source_parameters *p, void *s, source_outputs *y, char *message,
                  size_t size) {
  (void)s;
  if (!(p->gain > 0.0)) {
    (void)snprintf(message, size, "gain = %.17g, must be positive", p->gain);
    return false;
  }
  y->r[0] = 0.0;
  y->r[1] = 0.5 * p->gain;
  return true;
}

static void tick(const source_parameters *p, const source_inputs *u, void *s, source_outputs *y) {
  state *mine = s;
  (void)u;
  mine->k += 1.0;
  y->r[0] = (mine->k + 1.0) * floor(p->Ts / 0.00025 + 0.5);
  y->r[1] = p->gain * sin(0.01 * y->r[0]);
  y->fault = fabs(y->r[1]) > 100.0 ? 2.0 : 0.0;
}

FLEXHEX_BLOCK(source, state, start, tick)
"""

RELAY_C = """#include <math.h>
#include <string.h>

#include "relay.h"

typedef struct {
  double mixed;
} state;

static bool start(const relay_parameters *p, void *s, relay_outputs *y, char *message,
                  size_t size) {
  state *mine = s;
  (void)message;
  (void)size;
  mine->mixed = 0.25 * p->keep;
  y->y[0] = -1.0;
  y->y[1] = mine->mixed;
  return true;
}

static void tick(const relay_parameters *p, const relay_inputs *u, void *s, relay_outputs *y) {
  state *mine = s;
  mine->mixed = p->keep * mine->mixed + sin(u->u[1] - 0.3 * u->v);
  y->y[0] = u->u[0];
  y->y[1] = mine->mixed;
}

FLEXHEX_BLOCK(relay, state, start, tick)
"""

NOTHING_C = """#include <math.h>
#include <string.h>

#include "NAME.h"

typedef struct {
  double unused;
} state;

static bool start(const NAME_parameters *p, void *s, NAME_outputs *y, char *message, size_t size) {
  (void)p, (void)s, (void)y, (void)message, (void)size;
  return true;
}

static void tick(const NAME_parameters *p, const NAME_inputs *u, void *s, NAME_outputs *y) {
  (void)p, (void)u, (void)s, (void)y;
}

FLEXHEX_BLOCK(NAME, state, start, tick)
"""

KEEP, GAIN = 0.7, 1.3


def source(steps: int = 1) -> Interface:
    """Source of stamps with a period of `steps` base steps."""
    variables = (
        Variable("gain", "parameter", "1", "height of the wave", start=GAIN),
        Variable("r", "output", "1", "stamp and wave", size=2),
    )
    faults = (Item("wide", "wave beyond 100"),)
    return Interface(f"source{steps}", "toy source", steps * BASE_STEP, variables, faults=faults)


def relay(steps: int, limit: float = 1e6, name: str = "") -> Interface:
    """Relay with a period of `steps` base steps; stamps beyond limit are refused."""
    variables = (
        Variable("keep", "parameter", "1", "memory", start=KEEP, variability="tunable"),
        Variable("u", "input", "1", "stamp and wave", size=2, min=-limit, max=limit),
        Variable("v", "input", "1", "second wave"),
        Variable("y", "output", "1", "stamp and mixed wave", size=2),
    )
    return Interface(name or f"relay{steps}", "toy relay", steps * BASE_STEP, variables)


def build(interface: Interface, folder: Path) -> Path:
    """The toy's FMU in folder."""
    block = "source" if interface.name.startswith("source") else "relay"
    step = folder / "blocks" / block / "step.c"
    step.parent.mkdir(parents=True, exist_ok=True)
    step.write_text(SOURCE_C if block == "source" else RELAY_C)
    return build_fmu(interface, [], step, folder, cache=OBJECTS)


def chain(*steps: int) -> System:
    """A source of period 1 and relays c1, c2, ... of these periods, each fed by the one before."""
    names = [f"c{k}" for k in range(1, len(steps) + 1)]
    components = [Component("c0", source())]
    components += [Component(n, relay(s)) for n, s in zip(names, steps, strict=True)]
    connections = [("c0.r", "c1.u")]
    connections += [(f"{a}.y", f"{b}.u") for a, b in itertools.pairwise(names)]
    connections += [("c0.r[2]", f"{n}.v") for n in names]
    return System("chain", tuple(components), tuple(connections), plots=(f"{names[-1]}.y",))


def ring(limit: float = 1e6) -> System:
    """Source and relays of 1, 2 and 120 base steps that feed back into one another.

    a and c are instances of different FMUs, a and a2 of the same one.
    """
    last = relay(120) if limit == 1e6 else relay(4, limit, "relay_narrow")
    return System(
        "ring",
        (
            Component("src", source(), box=(0, 0, 80, 60)),
            Component("a", relay(1), box=(160, 0, 240, 60)),
            Component("a2", relay(1)),
            Component("b", relay(2)),
            Component("c", last),
        ),
        (
            ("src.r", "a.u"),
            ("a.y", "a2.u"),
            ("a2.y", "b.u"),
            ("b.y", "c.u"),
            ("c.y[2]", "a.v"),
            ("b.y[2]", "a2.v"),
            ("a.y[2]", "b.v"),
            ("src.r[2]", "c.v"),
        ),
        plots=("c.y", "c.fault"),
    )


def pack(system: System, folder: Path) -> Path:
    """Build the FMUs of a system of toys and write its .ssp."""
    for interface in {c.interface.name: c.interface for c in system.components}.values():
        build(interface, folder)
    return write_ssp(system, folder, folder / f"{system.name}.ssp")


class Twin:
    """A toy in plain Python under the timing rule: sample at k N (k >= 1), show at (k+1) N."""

    def __init__(self, steps: int, is_source: bool) -> None:
        self.steps, self.is_source, self.k = steps, is_source, 0
        self.mixed = 0.25 * KEEP
        self.shown = (0.0, 0.5 * GAIN) if is_source else (-1.0, self.mixed)
        self.pending = self.shown

    def step(self, n: int, u: tuple[float, float], v: float) -> None:
        """One base step from n to n + 1."""
        if n >= 1 and n % self.steps == 0:
            if self.is_source:
                self.k += 1
                stamp = float((self.k + 1) * self.steps)
                self.pending = (stamp, GAIN * math.sin(0.01 * stamp))
            else:
                self.mixed = KEEP * self.mixed + math.sin(u[1] - 0.3 * v)
                self.pending = (u[0], self.mixed)
        if (n + 1) % self.steps == 0:
            self.shown = self.pending


def jacobi(system: System, n_steps: int) -> dict[str, list[tuple[float, float]]]:
    """What every component shows at n = 0 ... n_steps when all advance at the base step."""
    twins = {
        c.name: Twin(system.steps(c.name), c.interface.name.startswith("source"))
        for c in system.components
    }
    feeds = {(w.target, w.input): (w.source, int(w.output[-2]) - 1) for w in system.wires}
    history = {name: [twin.shown] for name, twin in twins.items()}
    for n in range(n_steps):
        shown = {name: twin.shown for name, twin in twins.items()}

        def read(name: str, variable: str, now: dict[str, tuple[float, float]] = shown) -> float:
            start = feeds.get((name, variable))
            return now[start[0]][start[1]] if start else 0.0

        for name, twin in twins.items():
            twin.step(n, (read(name, "u[1]"), read(name, "u[2]")), read(name, "v"))
            history[name].append(twin.shown)
    return history
