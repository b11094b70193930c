/* Torque that a wanted motion needs; the last finite one when the input makes none. */
#include "inverse.h"

#include <math.h>
#include <string.h>

static const double FAULT_NOT_FINITE = 2.0;

typedef struct {
  double r[INVERSE_N], rd[INVERSE_N], rdd[INVERSE_N]; /* of the last sample */
  double z[INVERSE_N];                                /* presliding */
  double effects[INVERSE_N_STATES];
  bool moved;
} state;

static bool start(const inverse_parameters *p, void *memory, inverse_outputs *y, char *message,
                  size_t size) {
  (void)p, (void)message, (void)size;
  memset(memory, 0, sizeof(state));
  memset(y, 0, sizeof *y);
  return true;
}

static bool all_finite(const double *values, int count) {
  for (int i = 0; i < count; ++i) {
    if (!isfinite(values[i])) {
      return false;
    }
  }
  return true;
}

static void tick(const inverse_parameters *p, const inverse_inputs *u, void *memory,
                 inverse_outputs *y) {
  state *s = (state *)memory;
  double z[INVERSE_N], tau[INVERSE_N], effects[INVERSE_N_STATES];
  inverse_presliding(u->r, s->moved ? s->r : u->r, s->z, p->p, z);
  if (s->moved) {
    inverse_follow(s->r, s->rd, s->rdd, u->r, u->rd, u->rdd, s->effects, p->p, &p->Ts, effects);
  } else {
    inverse_start(u->r, p->p, effects);
  }
  inverse_torque(u->r, u->rd, u->rdd, z, effects, p->p, tau);
  if (!all_finite(tau, INVERSE_N) || !all_finite(z, INVERSE_N) ||
      !all_finite(effects, INVERSE_N_STATES)) {
    y->fault = FAULT_NOT_FINITE;
    return;
  }
  memcpy(s->r, u->r, sizeof s->r);
  memcpy(s->rd, u->rd, sizeof s->rd);
  memcpy(s->rdd, u->rdd, sizeof s->rdd);
  memcpy(s->z, z, sizeof z);
  memcpy(s->effects, effects, sizeof effects);
  s->moved = true;
  memcpy(y->tau_ff, tau, sizeof tau);
  y->fault = 0.0;
}

FLEXHEX_BLOCK(inverse, state, start, tick)
