/* Feedforward torque of the wanted motion; the last good torque when the input is no pose. */
#include "feedforward.h"

#include <math.h>
#include <string.h>

static const double FAULT_NOT_FINITE = 2.0;

typedef struct {
  double unused;
} state;

static bool start(const feedforward_parameters *p, void *memory, feedforward_outputs *y,
                  char *message, size_t size) {
  (void)p, (void)memory, (void)message, (void)size;
  memset(y, 0, sizeof *y);
  return true;
}

static void tick(const feedforward_parameters *p, const feedforward_inputs *u, void *memory,
                 feedforward_outputs *y) {
  (void)p, (void)memory;
  double tau[FEEDFORWARD_N];
  feedforward_torque(u->x, u->xd, u->xdd, u->z, u->p, tau);
  for (int i = 0; i < FEEDFORWARD_N; ++i) {
    if (!isfinite(tau[i])) {
      y->fault = FAULT_NOT_FINITE;
      return;
    }
  }
  memcpy(y->tau_ff, tau, sizeof tau);
  y->fault = 0.0;
}

FLEXHEX_ROOM(feedforward, state, start, tick)
