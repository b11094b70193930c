/* Columns of the effects at raw samples. Without effects all of this compiles to nothing. */
#ifndef FLEXHEX_FILTER_EFFECTS_H
#define FLEXHEX_FILTER_EFFECTS_H

#include <string.h>

#ifdef FILTER_N_EFFECT

enum { N_EFFECT = FILTER_N_EFFECT };

/* signals at which the columns are evaluated: by name here, as one vector in generated functions */
typedef struct {
  double theta[FILTER_N], thetad[FILTER_N], thetadd[FILTER_N];
  double tau[FILTER_N], taud[FILTER_N];
  double time;
} filter_signals;
typedef union {
  filter_signals of;
  double all[sizeof(filter_signals) / sizeof(double)];
} filter_instant;

typedef struct {
  filter_instant last;
  double state[FILTER_N_EFFECT_STATE];
  double ticks;
} filter_effects;

/* Columns of the middle one of three samples (theta, then tau), whose neighbours give its rates.
   At the first tick all three are one sample, at the second the middle one is that sample still:
   only then does time go on. */
static void filter_effects_at(filter_effects *e, double Ts, const double *past, const double *now,
                              const double *latest, double *columns) {
  filter_instant at;
  double state_next[FILTER_N_EFFECT_STATE], unused[FILTER_N];
  memcpy(at.of.theta, now, sizeof at.of.theta);
  memcpy(at.of.tau, now + FILTER_N, sizeof at.of.tau);
  filter_derivatives(past, now, latest, &Ts, at.of.thetad, at.of.thetadd);
  filter_derivatives(past + FILTER_N, now + FILTER_N, latest + FILTER_N, &Ts, at.of.taud, unused);
  at.of.time = e->ticks > 1.0 ? e->ticks * Ts : Ts;
  if (e->ticks == 0.0) {
    filter_effect_start(at.of.theta, e->state);
  } else if (e->ticks > 1.0) {
    filter_effect_advance(e->last.all, at.all, e->state, &Ts, state_next);
    memcpy(e->state, state_next, sizeof state_next);
  }
  filter_effect_columns(at.all, e->state, columns);
  e->last = at;
  e->ticks += 1.0;
}

#else

enum { N_EFFECT = 0 };

#endif
#endif
