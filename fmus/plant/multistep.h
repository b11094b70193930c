/* One evaluation of the dynamics a substep, from what the substeps before have found.

   thetadd = response(t) (tau(t), 1): the response of the mechanism is smooth along a motion, the
   torque is not, but it is known: level + gap exp(-rate t). So the response is interpolated by a
   polynomial through five substeps, and its product with the torque is integrated exactly. theta
   comes from the past alone; thetad is corrected by the response at the new theta. z follows
   theta in closed form. */
#ifndef FLEXHEX_PLANT_MULTISTEP_H
#define FLEXHEX_PLANT_MULTISTEP_H

#include "motion.h"

/* effects may follow the torque, or jump: Runge-Kutta throughout */
#if defined PLANT_N_EFFECT && !defined PLANT_CLASSICAL
#define PLANT_CLASSICAL
#endif

enum { NODES = 5 };
/* integrals over a substep: twice and once over the polynomial through the past, once over the one
   that ends at the substep's end */
enum { POSITION, PREDICTED, CORRECTED, WEIGHTS };
/* predicted and corrected thetad that are further apart [rad/s] belong to no smooth motion */
static const double APART = 1e-5;

/* slopes: at the last starts of substeps, the newest first; `known` of them hold for the payload.
   ahead: 1 when slopes[0] is where the motion is now. level, gap: `weigh`, late: of `gap`. */
typedef struct {
  slope slopes[NODES];
  double known, ahead, payload;
  double level[WEIGHTS][NODES], gap[WEIGHTS][NODES], late;
} history;

/* Integrals of t^k exp(-rate t) over t from 0 to 1, k = 0..NODES.

   k I_{k-1} - rate I_k = exp(-rate): forward where the rate is high; else backward from a series
   of positive terms, as forward would cancel. */
static void moments(double rate, double I[NODES + 1]) {
  const double end = exp(-rate);
  if (rate > NODES) {
    I[0] = (1.0 - end) / rate;
    for (int k = 1; k <= NODES; ++k) {
      I[k] = (k * I[k - 1] - end) / rate;
    }
    return;
  }
  double sum = 0.0, term = end;
  for (int k = NODES + 1; k < 40; ++k) {
    term /= k;
    sum += term;
    term *= rate;
  }
  I[NODES] = sum;
  for (int k = NODES; k > 0; --k) {
    I[k - 1] = (rate * I[k] + end) / k;
  }
}

/* 24 times the polynomials in t that are 1 at one node and 0 at the others, from the lowest power
 */
static const double BEHIND[NODES][NODES] = {
    {24.0, 50.0, 35.0, 10.0, 1.0},     /* 0 */
    {0.0, -96.0, -104.0, -36.0, -4.0}, /* -1 */
    {0.0, 72.0, 114.0, 48.0, 6.0},     /* -2 */
    {0.0, -32.0, -56.0, -28.0, -4.0},  /* -3 */
    {0.0, 6.0, 11.0, 6.0, 1.0},        /* -4 */
};
static const double ENDING[NODES][NODES] = {
    {0.0, 6.0, 11.0, 6.0, 1.0},       /* 1 */
    {24.0, 20.0, -20.0, -20.0, -4.0}, /* 0 */
    {0.0, -36.0, 6.0, 24.0, 6.0},     /* -1 */
    {0.0, 12.0, 4.0, -12.0, -4.0},    /* -2 */
    {0.0, -2.0, -1.0, 2.0, 1.0},      /* -3 */
};

/* weight[kind][j]: integral of exp(-rate t) times the polynomial of node j. */
static void weigh(double rate, double weight[WEIGHTS][NODES]) {
  double I[NODES + 1];
  moments(rate, I);
  memset(weight, 0, WEIGHTS * sizeof weight[0]);
  for (int j = 0; j < NODES; ++j) {
    for (int k = 0; k < NODES; ++k) {
      weight[POSITION][j] += BEHIND[j][k] / 24.0 * (I[k] - I[k + 1]);
      weight[PREDICTED][j] += BEHIND[j][k] / 24.0 * I[k];
      weight[CORRECTED][j] += ENDING[j][k] / 24.0 * I[k];
    }
  }
}

static void history_start(const plant_parameters *p, history *past) {
  const double h = p->Ts / p->substeps;
  double rate, I[NODES + 1];
  plant_decay(&p->f_current, &h, &rate);
  memset(past, 0, sizeof *past);
  moments(rate, I);
  past->late = I[0] - I[1];
  weigh(0.0, past->level);
  weigh(rate, past->gap);
}

static void forget(history *past) {
  past->known = past->ahead = 0.0;
}

/* Add the slope where the motion is now. */
static void remember(const plant_parameters *p, const action *a, const motion *now, history *past) {
  memmove(past->slopes + 1, past->slopes, (NODES - 1) * sizeof past->slopes[0]);
  evaluate(p, a, now, 0, past->slopes);
  past->ahead = 1.0;
#ifndef PLANT_CLASSICAL
  past->known = fmin(past->known + 1.0, NODES);
#endif
}

/* Integral (N,) of the acceleration over the substep, in units of h or h^2. */
static void integral(const history *past, const action *a, int kind, double sum[N]) {
  memset(sum, 0, N * sizeof(double));
  for (int j = 0; j < NODES; ++j) {
    for (int k = 0; k <= N; ++k) {
      const double part = a->level[k] * past->level[kind][j] + a->gap[k] * past->gap[kind][j];
      for (int i = 0; i < N; ++i) {
        sum[i] += past->slopes[j].response[N * k + i] * part;
      }
    }
  }
}

/* Where the past leads: theta and z, thetad and d nearly. */
static void predict(const history *past, const action *a, motion *now) {
  const motion before = *now;
  double sum[N];
  integral(past, a, POSITION, sum);
  for (int i = 0; i < N; ++i) {
    now->of.theta[i] += a->h * (before.of.thetad[i] + a->h * sum[i]);
  }
  integral(past, a, PREDICTED, sum);
  for (int i = 0; i < N; ++i) {
    now->of.thetad[i] += a->h * sum[i];
  }
  hysteresis(&before, a->h, now);
  for (int j = 0; j < NODES; ++j) {
    for (int i = 0; i < N_D; ++i) {
      now->of.d[i] += a->h * past->level[PREDICTED][j] * past->slopes[j].dd[i];
    }
  }
}

/* thetad from the slope at the end; false when it is not near the predicted one. */
static bool correct(const history *past, const action *a, const double *thetad, motion *now) {
  double sum[N];
  bool near = true;
  integral(past, a, CORRECTED, sum);
  for (int i = 0; i < N; ++i) {
    const double corrected = thetad[i] + a->h * sum[i];
    near = near && fabs(corrected - now->of.thetad[i]) < APART;
    now->of.thetad[i] = corrected;
  }
  return near;
}

#endif
