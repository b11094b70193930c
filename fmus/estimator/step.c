/* Kalman filter of the normalised parameters q = p / scale, all torques of a tick at once.

   With H = Phi diag(scale), few nonzeros in a row, and S = H P H' + R2 I = L L':
     W = P H' L^-T,  q += W L^-1 (tau - Phi p),  P -= W W'
   P is symmetric; what lies right of its blocks on the diagonal is neither kept nor read. */
#include "estimator.h"

#include "covariance.h"

#include <math.h>
#include <string.h>

static const double FAULT_NOT_FINITE = 2.0, FAULT_NO_COVARIANCE = 3.0;

typedef bool update(const estimator_parameters *p, state *s, const measurement *m);

/* The fastest form that this processor has; the same for all instances. */
static update *best = updated_in_pairs;

static void publish(const estimator_parameters *p, const state *s, estimator_outputs *y) {
  for (int k = 0; k < N_P; ++k) {
    y->p[k] = p->adapt[k] != 0.0 ? p->scale[k] * s->q[k] : p->p0[k];
    y->p_std[k] = p->scale[k] * sqrt(s->P[k][k]);
  }
}

static bool start(const estimator_parameters *p, void *memory, estimator_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
#ifdef QUADS
  best = quads_there() ? updated_in_quads : updated_in_pairs;
#endif
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  estimator_columns(s->columns);
  for (int k = 0; k < N_P; ++k) {
    if (p->adapt[k] != 0.0 && p->adapt[k] != 1.0) {
      snprintf(message, size, "adapt[%d] = %.17g, must be 0 or 1", k + 1, p->adapt[k]);
      return false;
    }
    s->q[k] = p->p0[k] / p->scale[k];
    s->P[k][k] = p->P0[k] * p->adapt[k];
  }
  publish(p, s, y);
  return true;
}

static void measure(const estimator_parameters *p, const state *s, const double *phi,
                    const double *columns, double tau, measurement *m) {
  m->innovation = tau;
  for (int k = 0; k < WIDTH; ++k) {
    m->column[k] = (int)columns[k];
    m->h[k] = phi[k] * p->scale[m->column[k]];
    m->innovation -= m->h[k] * s->q[m->column[k]];
  }
}

static bool all_finite(const double *values, int count) {
  for (int k = 0; k < count; ++k) {
    if (!isfinite(values[k])) {
      return false;
    }
  }
  return true;
}

static void tick(const estimator_parameters *p, const estimator_inputs *u, void *memory,
                 estimator_outputs *y) {
  state *s = (state *)memory;
  s->ticks += 1.0;
  if (s->ticks * p->Ts < p->t_start) {
    return;
  }
  double phi[N * WIDTH];
  estimator_regressor(u->x, u->xd, u->xdd, u->chi_f, phi);
  if (!all_finite(phi, N * WIDTH)) {
    y->fault = FAULT_NOT_FINITE;
    return;
  }
  measurement m[N];
  for (int i = 0; i < N; ++i) {
    measure(p, s, phi + i * WIDTH, s->columns + i * WIDTH, u->tau_f[i], &m[i]);
    y->innovation[i] = m[i].innovation;
  }
  for (int k = 0; k < N_P; ++k) {
    s->P[k][k] += p->R1[k] * p->adapt[k];
  }
  if (!best(p, s, m)) {
    y->fault = FAULT_NO_COVARIANCE;
    return;
  }
  publish(p, s, y);
  y->fault = 0.0;
}

FLEXHEX_BLOCK(estimator, state, start, tick)
