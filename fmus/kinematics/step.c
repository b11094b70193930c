/* Newton-Raphson kinematics: predict, correct, check; the last good pose where that fails. */
#include "kinematics.h"

#include <math.h>
#include <string.h>

enum { RETRIES = 12 };
static const double FAULT_UNREACHABLE = 2.0;

/* the last good pose stands in the outputs, which stay until they are written */
typedef struct {
  double theta_last[KINEMATICS_N];
  double z[KINEMATICS_N];
  double started;
} state;

static bool start(const kinematics_parameters *p, void *memory, kinematics_outputs *y,
                  char *message, size_t size) {
  state *s = (state *)memory;
  if (p->corrections != floor(p->corrections)) {
    snprintf(message, size, "corrections = %.17g, must be a whole number", p->corrections);
    return false;
  }
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  kinematics_neutral(y->x + KINEMATICS_N);
  y->converged = 1.0;
  return true;
}

/* d after so many corrections: in the one or the other of the two places, the first begins. */
static double *correct(const double *half, double *d, double *other, int times) {
  for (int k = 0; k < times; ++k) {
    kinematics_correct(half, d, other);
    double *next = other;
    other = d;
    d = next;
  }
  return d;
}

/* Rates and residual at d, into the outputs; true when the loops are closed. */
static bool evaluate(const kinematics_parameters *p, const kinematics_inputs *u, const double *half,
                     const double *d, kinematics_outputs *y) {
  kinematics_rates(half, d, u->thetad, u->thetadd, y->xd, y->xdd, &y->residual);
  if (!(y->residual <= p->tolerance)) {
    return false;
  }
  for (int k = 0; k < KINEMATICS_N_X; ++k) {
    if (!isfinite(y->xdd[k])) {
      return false;
    }
  }
  return true;
}

static void hold(kinematics_outputs *y) {
  memset(y->xd, 0, sizeof y->xd);
  memset(y->xdd, 0, sizeof y->xdd);
  y->residual = isfinite(y->residual) ? y->residual : DBL_MAX;
  y->converged = 0.0;
  y->fault = FAULT_UNREACHABLE;
}

static void tick(const kinematics_parameters *p, const kinematics_inputs *u, void *memory,
                 kinematics_outputs *y) {
  state *s = (state *)memory;
  /* hysteresis follows the angle alone; at the first tick there is no earlier one */
  if (s->started != 0.0) {
    double z_next[KINEMATICS_N];
    kinematics_dahl(s->z, s->theta_last, u->theta, z_next);
    memcpy(s->z, z_next, sizeof s->z);
  }
  memcpy(s->theta_last, u->theta, sizeof s->theta_last);
  memcpy(y->z, s->z, sizeof y->z);

  /* the regular way: one prediction, the wanted corrections */
  double half[2 * KINEMATICS_N], place[KINEMATICS_N_D], other[KINEMATICS_N_D];
  double *const last = y->x + KINEMATICS_N;
  kinematics_turn(u->theta, half);
  kinematics_predict(last, y->xd + KINEMATICS_N, y->xdd + KINEMATICS_N, &p->Ts, place);
  const double *d = correct(half, place, other, (int)p->corrections);
  bool good = s->started != 0.0 && evaluate(p, u, half, d, y);

  /* a jump of the angle: again from neutral, which leads to the assembly that the machine has;
     from the last good pose a far jump may end in another one, and stay there */
  for (int attempt = 0; !good && attempt < 2; ++attempt) {
    if (attempt == 0) {
      kinematics_neutral(place);
    } else {
      memcpy(place, last, sizeof place);
    }
    d = correct(half, place, other, RETRIES);
    good = evaluate(p, u, half, d, y);
  }
  if (!good) {
    hold(y);
    return;
  }
  s->started = 1.0;
  memcpy(y->x, u->theta, sizeof u->theta);
  memcpy(last, d, sizeof place);
  y->converged = 1.0;
  y->fault = 0.0;
}

FLEXHEX_BLOCK(kinematics, state, start, tick)
