/* Feedforward torque of the reference motion; the last finite torque when the input is no pose. */
#include "feedforward.h"

#include "effects.h"

#include <math.h>
#include <string.h>

static const double FAULT_NOT_FINITE = 2.0;

typedef struct {
  feedforward_effects effects;
} state;

static bool start(const feedforward_parameters *p, void *memory, feedforward_outputs *y,
                  char *message, size_t size) {
  (void)p, (void)message, (void)size;
  memset(memory, 0, sizeof(state));
  memset(y, 0, sizeof *y);
  return true;
}

static bool all_finite(const double *tau) {
  for (int i = 0; i < FEEDFORWARD_N; ++i) {
    if (!isfinite(tau[i])) {
      return false;
    }
  }
  return true;
}

static void tick(const feedforward_parameters *p, const feedforward_inputs *u, void *memory,
                 feedforward_outputs *y) {
  state *s = (state *)memory;
  double tau[FEEDFORWARD_N];
  feedforward_torque(u->x, u->xd, u->xdd, u->z, u->p, tau);
  if (!all_finite(tau)) {
    y->fault = FAULT_NOT_FINITE;
    return;
  }
  add_effects(p, u, &s->effects, tau);
  if (!all_finite(tau)) {
    y->fault = FAULT_NOT_FINITE;
    return;
  }
  memcpy(y->tau_ff, tau, sizeof tau);
  y->fault = 0.0;
}

FLEXHEX_BLOCK(feedforward, state, start, tick)
