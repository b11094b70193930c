/* Torque that a wanted motion needs; the last finite one when the input makes none. */
#include "inverse.h"

#include <math.h>
#include <string.h>

static const double FAULT_NOT_FINITE = 2.0;

typedef struct {
  double before[INVERSE_N]; /* positions of the last sample */
  double z[INVERSE_N];      /* presliding */
  bool moved;
} state;

static bool start(const inverse_parameters *p, void *memory, inverse_outputs *y, char *message,
                  size_t size) {
  (void)p, (void)message, (void)size;
  memset(memory, 0, sizeof(state));
  memset(y, 0, sizeof *y);
  return true;
}

static bool all_finite(const double *values) {
  for (int i = 0; i < INVERSE_N; ++i) {
    if (!isfinite(values[i])) {
      return false;
    }
  }
  return true;
}

static void tick(const inverse_parameters *p, const inverse_inputs *u, void *memory,
                 inverse_outputs *y) {
  state *s = (state *)memory;
  double z[INVERSE_N], tau[INVERSE_N];
  inverse_presliding(u->r, s->moved ? s->before : u->r, s->z, p->p, z);
  inverse_torque(u->r, u->rd, u->rdd, z, p->p, tau);
  if (!all_finite(tau) || !all_finite(z)) {
    y->fault = FAULT_NOT_FINITE;
    return;
  }
  memcpy(s->before, u->r, sizeof s->before);
  memcpy(s->z, z, sizeof z);
  s->moved = true;
  memcpy(y->tau_ff, tau, sizeof tau);
  y->fault = 0.0;
}

FLEXHEX_ROOM(inverse, state, start, tick)
