/* Effects of one machine that its truth file lists under [[hidden]], in physical forms.
   Written independently of the library of effects.

   Rates are differences of the exact angle over the last tick. */
#ifndef FLEXHEX_MACHINE_HIDDEN_EFFECTS_H
#define FLEXHEX_MACHINE_HIDDEN_EFFECTS_H

#include <math.h>
#include <string.h>

/* numbers as in truth.py */
enum hidden_kind {
  HIDDEN_LUGRE,
  HIDDEN_CUBIC,
  HIDDEN_CABLE,
  HIDDEN_SATURATION,
  HIDDEN_HARMONIC,
  HIDDEN_DRAG,
  HIDDEN_RIPPLE,
  HIDDEN_BUMP,
  HIDDEN_INERTIA
};
/* kind, axis from 0, four values */
enum { HIDDEN_WIDTH = 6 };
static const double HIDDEN_HINGE = 0.004; /* angle over which a cable tightens [rad] */

typedef struct {
  double last[PLANT_N], before[PLANT_N];
  double bristle[PLANT_N_HIDDEN];
  double started;
} hidden_motion;

static void hidden_motion_start(hidden_motion *m) {
  memset(m, 0, sizeof *m);
}

/* Friction of bristles (Canudas de Wit et al. 1995), exact while the rate is constant. */
static double hidden_lugre(const double *v, double rate, double h, double *bristle) {
  const double ratio = rate / v[2];
  const double level = v[0] + (v[1] - v[0]) * exp(-ratio * ratio);
  if (rate != 0.0) {
    const double limit = copysign(level / v[3], rate);
    *bristle = limit + (*bristle - limit) * exp(-v[3] * fabs(rate) * h / level);
  }
  return v[3] * *bristle;
}

/* Slack, then a spring: the corner is round. */
static double hidden_cable(const double *v, double theta) {
  const double pull = v[2] * (theta - v[1]);
  return v[0] * v[2] * 0.5 * (pull + sqrt(pull * pull + HIDDEN_HINGE * HIDDEN_HINGE));
}

/* Inertia v0 sin(v1 theta + v2): Lagrange's terms of it. */
static double hidden_inertia(const double *v, double theta, double rate, double rise) {
  const double phase = v[1] * theta + v[2];
  return v[0] * sin(phase) * rise + 0.5 * v[0] * v[1] * cos(phase) * rate * rate;
}

static double hidden_effect(const double *row, hidden_motion *m, int k, double h, double theta,
                            double tau) {
  const int i = (int)row[1];
  const double *v = row + 2;
  const double rate = (theta - m->last[i]) / h;
  const double rise = (theta - 2.0 * m->last[i] + m->before[i]) / (h * h);
  const double off = (theta - v[1]) / v[2];
  switch ((enum hidden_kind)row[0]) {
    case HIDDEN_LUGRE:
      return hidden_lugre(v, rate, h, &m->bristle[k]);
    case HIDDEN_CUBIC:
      return v[0] * theta * theta * theta;
    case HIDDEN_CABLE:
      return hidden_cable(v, theta);
    case HIDDEN_SATURATION:
      return tau * tau * tau / (tau * tau + v[0] * v[0]);
    case HIDDEN_HARMONIC:
      return v[0] * cos(v[1] * theta + v[2]);
    case HIDDEN_DRAG:
      return v[0] * rate * fabs(rate);
    case HIDDEN_RIPPLE:
      return v[0] * tau * cos(v[1] * theta + v[2]);
    case HIDDEN_BUMP:
      return v[0] * exp(-off * off);
    case HIDDEN_INERTIA:
      return hidden_inertia(v, theta, rate, rise);
  }
  return 0.0;
}

static void hidden_effects(const plant_parameters *p, hidden_motion *m, const double *theta,
                           const double *tau_motor, double *torque) {
  if (m->started == 0.0) {
    memcpy(m->before, theta, sizeof m->before);
    memcpy(m->last, theta, sizeof m->last);
  }
  for (int k = 0; k < PLANT_N_HIDDEN; ++k) {
    const double *row = p->hidden_effects + HIDDEN_WIDTH * k;
    const int i = (int)row[1];
    torque[i] += hidden_effect(row, m, k, p->Ts, theta[i], tau_motor[i]);
  }
  memcpy(m->before, m->last, sizeof m->before);
  memcpy(m->last, theta, sizeof m->last);
  m->started = 1.0;
}

#endif
