/* Newton-Raphson kinematics: predict, correct, judge; hold the last good pose otherwise. */
#include "kinematics.h"

#include <math.h>
#include <string.h>

enum { RETRIES = 12 };
static const double FAULT_UNREACHABLE = 2.0;

typedef struct {
  double d[KINEMATICS_N_D];
  double theta_last[KINEMATICS_N];
  double z[KINEMATICS_N];
  double started;
} state;

static bool start(const kinematics_parameters *p, void *memory, kinematics_outputs *y,
                  char *message, size_t size) {
  state *s = memory;
  if (p->corrections != floor(p->corrections)) {
    snprintf(message, size, "corrections = %.17g, must be a whole number", p->corrections);
    return false;
  }
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  kinematics_neutral(s->d);
  memcpy(y->x + KINEMATICS_N, s->d, sizeof s->d);
  y->converged = 1.0;
  return true;
}

static void correct(const double *theta, double *d, int times) {
  for (int k = 0; k < times; ++k) {
    double d_next[KINEMATICS_N_D];
    kinematics_correct(theta, d, d_next);
    memcpy(d, d_next, sizeof d_next);
  }
}

/* Rates and residual at d; true when the loops are closed. */
static bool evaluate(const kinematics_parameters *p, const kinematics_inputs *u, const double *d,
                     double *xd, double *xdd, double *residual) {
  kinematics_rates(u->theta, d, u->thetad, u->thetadd, xd, xdd, residual);
  if (!(*residual <= p->tolerance)) {
    return false;
  }
  for (int k = 0; k < KINEMATICS_N_X; ++k) {
    if (!isfinite(xdd[k])) {
      return false;
    }
  }
  return true;
}

static void hold(kinematics_outputs *y, double residual) {
  memset(y->xd, 0, sizeof y->xd);
  memset(y->xdd, 0, sizeof y->xdd);
  y->residual = isfinite(residual) ? residual : DBL_MAX;
  y->converged = 0.0;
  y->fault = FAULT_UNREACHABLE;
}

static void tick(const kinematics_parameters *p, const kinematics_inputs *u, void *memory,
                 kinematics_outputs *y) {
  state *s = memory;
  double d[KINEMATICS_N_D], xd[KINEMATICS_N_X], xdd[KINEMATICS_N_X], residual = 0.0;

  /* hysteresis follows the angle alone; the first tick knows no earlier one */
  if (s->started != 0.0) {
    double z_next[KINEMATICS_N];
    kinematics_dahl(s->z, s->theta_last, u->theta, z_next);
    memcpy(s->z, z_next, sizeof s->z);
  }
  memcpy(s->theta_last, u->theta, sizeof s->theta_last);
  memcpy(y->z, s->z, sizeof y->z);

  /* the regular way: one prediction, the wanted corrections */
  kinematics_predict(s->d, y->xd + KINEMATICS_N, y->xdd + KINEMATICS_N, &p->Ts, d);
  correct(u->theta, d, (int)p->corrections);
  bool good = s->started != 0.0 && evaluate(p, u, d, xd, xdd, &residual);

  /* a jump of the angle: again from neutral, which leads to the assembly that the machine has;
     from the last good pose a far jump may end in another one, and stay there */
  for (int attempt = 0; !good && attempt < 2; ++attempt) {
    if (attempt == 0) {
      kinematics_neutral(d);
    } else {
      memcpy(d, s->d, sizeof d);
    }
    correct(u->theta, d, RETRIES);
    good = evaluate(p, u, d, xd, xdd, &residual);
  }
  if (!good) {
    hold(y, residual);
    return;
  }
  s->started = 1.0;
  memcpy(s->d, d, sizeof s->d);
  memcpy(y->x, u->theta, sizeof u->theta);
  memcpy(y->x + KINEMATICS_N, d, sizeof d);
  memcpy(y->xd, xd, sizeof xd);
  memcpy(y->xdd, xdd, sizeof xdd);
  y->residual = residual;
  y->converged = 1.0;
  y->fault = 0.0;
}

FLEXHEX_ROOM(kinematics, state, start, tick)
