/* The motion of the plant: its state, its rates, and the classical Runge-Kutta step. */
#ifndef FLEXHEX_PLANT_MOTION_H
#define FLEXHEX_PLANT_MOTION_H

#include "effects.h"

#include <math.h>
#include <string.h>

/* C has no empty array: a machine without a platform has one d, which stays zero */
enum { N = PLANT_N, N_D = PLANT_N_D > 0 ? PLANT_N_D : 1 };

/* the state that is integrated: by name in the equations, as one vector in the integrator */
typedef struct {
  double theta[N], thetad[N], d[N_D], z[N];
#ifdef PLANT_N_EFFECT
  double effect[PLANT_N_EFFECT_STATE];
#endif
} motion_parts;
enum { N_MOTION = sizeof(motion_parts) / sizeof(double) };
typedef union {
  motion_parts of;
  double all[N_MOTION];
} motion;

/* What acts in a substep of h. tau: at its start, middle and end, the middle such that Simpson's
   rule gives the impulse; then the integral of (1 - t) tau over t from 0 to 1. */
typedef struct {
  double h, payload, tau[4][N];
  /* the same as level + gap exp(-rate t); [N]: the factor of what does not depend on torque */
  double level[N + 1], gap[N + 1];
#ifdef PLANT_N_EFFECT
  const plant_effects *effects;
#endif
} action;

/* Rates at one instant for any torque: thetadd = sum_k response[N k + i] tau[k], tau[N] = 1. */
typedef struct {
  double response[(N + 1) * N], dd[N_D], zd[N];
#ifdef PLANT_N_EFFECT
  double stated[PLANT_N_EFFECT_STATE];
#endif
} slope;

/* stage: 0 at the start of a substep, 1 in its middle, 2 at its end */
static void evaluate(const plant_parameters *p, const action *a, const motion *at, int stage,
                     slope *rates) {
#if PLANT_N_D == 0
  rates->dd[0] = 0.0;
#endif
#ifdef PLANT_N_EFFECT
  const plant_effects *e = a->effects;
  plant_rates(at->of.theta, at->of.thetad, at->of.d, at->of.z, p->mechanism, p->actuator,
              &a->payload, e->motor[stage], e->taud, &e->time[stage], at->of.effect, p->effect,
              rates->response, rates->dd, rates->zd, rates->stated);
#else
  (void)stage;
  plant_rates(at->of.theta, at->of.thetad, at->of.d, at->of.z, p->mechanism, p->actuator,
              &a->payload, rates->response, rates->dd, rates->zd);
#endif
}

static motion rate_of(const slope *rates, const motion *at, const double *tau) {
  motion rate;
  memcpy(rate.of.theta, at->of.thetad, sizeof rate.of.theta);
  memcpy(rate.of.thetad, rates->response + N * N, sizeof rate.of.thetad);
  for (int k = 0; k < N; ++k) {
    for (int i = 0; i < N; ++i) {
      rate.of.thetad[i] += rates->response[N * k + i] * tau[k];
    }
  }
  memcpy(rate.of.d, rates->dd, sizeof rate.of.d);
  memcpy(rate.of.z, rates->zd, sizeof rate.of.z);
#ifdef PLANT_N_EFFECT
  memcpy(rate.of.effect, rates->stated, sizeof rate.of.effect);
#endif
  return rate;
}

static motion moved(const motion *from, double h, const motion *rate) {
  motion to;
  for (int k = 0; k < N_MOTION; ++k) {
    to.all[k] = from->all[k] + h * rate->all[k];
  }
  return to;
}

static motion stage_rate(const plant_parameters *p, const action *a, const motion *at, int stage) {
  slope rates;
  evaluate(p, a, at, stage, &rates);
  return rate_of(&rates, at, a->tau[stage]);
}

/* Displacement until the rate changes sign; the whole one where it does not. The rate is quadratic:
   first and last [rad per substep] are given, and the whole displacement [rad]. */
static double until_turn(double first, double last, double whole) {
  if (!(first * last < 0.0)) {
    return whole;
  }
  /* first + b t + c t^2 = 0 */
  const double b = 6.0 * whole - 4.0 * first - 2.0 * last, c = 3.0 * (first + last - 2.0 * whole);
  const double q = -0.5 * (b + copysign(sqrt(b * b - 4.0 * c * first), b)), root = first / q;
  const double t = root >= 0.0 && root <= 1.0 ? root : q / c;
  return t * (first + t * (b / 2.0 + t * (c / 3.0)));
}

/* z where theta has got to, in closed form: each joint turns once at most. */
static void hysteresis(const motion *before, double h, motion *now) {
  double until[N], after[N], z[N];
  for (int i = 0; i < N; ++i) {
    const double whole = now->of.theta[i] - before->of.theta[i];
    until[i] = until_turn(h * before->of.thetad[i], h * now->of.thetad[i], whole);
    after[i] = whole - until[i];
  }
  plant_dahl(before->of.z, until, z);
  plant_dahl(z, after, now->of.z);
}

/* One Runge-Kutta step from `now`, where the slope is `begin`. Simpson's rule knows the impulse of
   the torque; how far it has moved theta by the end is put right. */
static void runge_kutta(const plant_parameters *p, const action *a, const slope *begin,
                        motion *now) {
  const double h = a->h;
  const motion before = *now;
  const motion k1 = rate_of(begin, now, a->tau[0]);
  motion at = moved(now, h / 2, &k1);
  const motion k2 = stage_rate(p, a, &at, 1);
  at = moved(now, h / 2, &k2);
  const motion k3 = stage_rate(p, a, &at, 1);
  at = moved(now, h, &k3);
  const motion k4 = stage_rate(p, a, &at, 2);
  for (int k = 0; k < N_MOTION; ++k) {
    now->all[k] += h / 6 * (k1.all[k] + 2 * (k2.all[k] + k3.all[k]) + k4.all[k]);
  }
  for (int k = 0; k < N; ++k) {
    const double missing = h * h * (a->tau[3][k] - (a->tau[0][k] + 2 * a->tau[1][k]) / 6);
    for (int i = 0; i < N; ++i) {
      now->of.theta[i] += missing * begin->response[N * k + i];
    }
  }
  hysteresis(&before, h, now);
}

#endif
