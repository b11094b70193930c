/* Torque of the effects along the reference motion. Without effects all of this does nothing. */
#ifndef FLEXHEX_FEEDFORWARD_EFFECTS_H
#define FLEXHEX_FEEDFORWARD_EFFECTS_H

#include <string.h>

#ifdef FEEDFORWARD_N_EFFECT

/* signals at which the columns are evaluated: by name here, as one vector in generated functions */
typedef struct {
  double theta[FEEDFORWARD_N], thetad[FEEDFORWARD_N], thetadd[FEEDFORWARD_N];
  double tau[FEEDFORWARD_N], taud[FEEDFORWARD_N];
  double time;
} feedforward_signals;
typedef union {
  feedforward_signals of;
  double all[sizeof(feedforward_signals) / sizeof(double)];
} feedforward_instant;

typedef struct {
  feedforward_instant last;
  double base[2][FEEDFORWARD_N];
  double state[FEEDFORWARD_N_EFFECT_STATE];
  double ticks;
} feedforward_effects;

/* Adds the effects' torque to the model's; the states are advanced along the reference motion. */
static void add_effects(const feedforward_parameters *p, const feedforward_inputs *u,
                        feedforward_effects *e, double tau[FEEDFORWARD_N]) {
  feedforward_instant now;
  memcpy(now.of.theta, u->x, sizeof now.of.theta);
  memcpy(now.of.thetad, u->xd, sizeof now.of.thetad);
  memcpy(now.of.thetadd, u->xdd, sizeof now.of.thetadd);
  memcpy(now.of.tau, tau, sizeof now.of.tau);
  memset(now.of.taud, 0, sizeof now.of.taud);
  if (e->ticks > 1.0) { /* the first two samples have no two before them */
    feedforward_effect_torque_rate(e->base[1], e->base[0], tau, &p->Ts, now.of.taud);
  }
  now.of.time = (e->ticks + 1.0) * p->Ts;
  if (e->ticks == 0.0) {
    feedforward_effect_start(now.of.theta, e->state);
  } else {
    feedforward_instant whole = now;
    double state_next[FEEDFORWARD_N_EFFECT_STATE];
    feedforward_with_effects(now.all, e->state, u->p, whole.of.tau);
    feedforward_effect_advance(e->last.all, whole.all, e->state, &p->Ts, state_next);
    memcpy(e->state, state_next, sizeof state_next);
  }
  feedforward_with_effects(now.all, e->state, u->p, tau);
  memcpy(e->base[1], e->base[0], sizeof e->base[0]);
  memcpy(e->base[0], now.of.tau, sizeof e->base[0]);
  e->last = now;
  memcpy(e->last.of.tau, tau, sizeof e->last.of.tau);
  e->ticks += 1.0;
}

#else

typedef struct {
  double none;
} feedforward_effects;

static void add_effects(const feedforward_parameters *p, const feedforward_inputs *u,
                        feedforward_effects *e, double tau[FEEDFORWARD_N]) {
  (void)p, (void)u, (void)e, (void)tau;
}

#endif
#endif
