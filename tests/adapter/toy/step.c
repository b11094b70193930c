/* The test block: a delayed gain, an integrator, a count of ticks, a fault on demand. */
#include "toy.h"

#include <string.h>

static const double FAULT_EDGE = 2.0, FORBIDDEN = 7.0, EDGE = 0.9;

typedef struct {
  double integral[TOY_N];
  double ticks;
} state;

static bool start(const toy_parameters *p, void *memory, toy_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
  if (p->offset == FORBIDDEN) {
    snprintf(message, size, "offset = %g, must not be seven", p->offset);
    return false;
  }
  if (s->integral[0] != 0.0 || y->integral[0] != 0.0) {
    snprintf(message, size, "state and outputs must come in zeroed");
    return false;
  }
  memcpy(s->integral, p->begin, sizeof s->integral);
  memcpy(y->integral, p->begin, sizeof y->integral);
  y->y = p->offset;
  return true;
}

static void tick(const toy_parameters *p, const toy_inputs *u, void *memory, toy_outputs *y) {
  state *s = (state *)memory;
  double next[TOY_N];
  y->last = y->y;
  toy_scale(&u->u, &p->gain, &p->offset, &y->y);
  toy_integrate(s->integral, u->a, &p->Ts, next);
  memcpy(s->integral, next, sizeof s->integral);
  memcpy(y->integral, next, sizeof y->integral);
  s->ticks += 1.0;
  y->ticks = s->ticks;
  y->fault = u->u > EDGE ? FAULT_EDGE : 0.0;
}

FLEXHEX_BLOCK(toy, state, start, tick)
