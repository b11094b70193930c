/* Kalman filter of the normalised parameters q = p / scale, one torque after the other.

   The measurement noise is the same and independent for all torques, so six scalar updates
   equal one update with all six; each row of Phi has few nonzeros, so P h needs few rows of P.
     h = phi * scale,  w = P h / sqrt(h' P h + R2),  q += w (tau - phi p) / sqrt(.),  P -= w w'
   P -= w w' is symmetric to the last bit. */
#include "estimator.h"

#include <math.h>
#include <string.h>

enum { N = ESTIMATOR_N, N_P = ESTIMATOR_N_P, WIDTH = ESTIMATOR_WIDTH };
static const double FAULT_NOT_FINITE = 2.0;

typedef struct {
  double q[N_P];
  double P[N_P][N_P];
  double columns[N * WIDTH];
  double ticks;
} state;

static void publish(const estimator_parameters *p, const state *s, estimator_outputs *y) {
  for (int k = 0; k < N_P; ++k) {
    y->p[k] = p->adapt[k] != 0.0 ? p->scale[k] * s->q[k] : p->p0[k];
    y->p_std[k] = p->scale[k] * sqrt(s->P[k][k]);
  }
}

static bool start(const estimator_parameters *p, void *memory, estimator_outputs *y, char *message,
                  size_t size) {
  state *s = memory;
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  estimator_columns(s->columns);
  for (int k = 0; k < N_P; ++k) {
    if (p->adapt[k] != 0.0 && p->adapt[k] != 1.0) {
      snprintf(message, size, "adapt[%d] = %.17g, must be 0 or 1", k + 1, p->adapt[k]);
      return false;
    }
    s->q[k] = p->p0[k] / p->scale[k];
    s->P[k][k] = p->P0 * p->adapt[k];
  }
  publish(p, s, y);
  return true;
}

/* What p misses of one torque, tau - phi p. */
static double miss(const estimator_parameters *p, const state *s, const double *phi,
                   const double *columns, double tau) {
  for (int k = 0; k < WIDTH; ++k) {
    const int column = (int)columns[k];
    tau -= phi[k] * p->scale[column] * s->q[column];
  }
  return tau;
}

/* One scalar measurement: row phi at the given columns, torque tau. */
static void update(const estimator_parameters *p, state *s, const double *phi,
                   const double *columns, double tau) {
  const double error = miss(p, s, phi, columns, tau);
  double w[N_P] = {0.0}, variance = p->R2;
  for (int k = 0; k < WIDTH; ++k) {
    const int column = (int)columns[k];
    const double h = phi[k] * p->scale[column];
    const double *row = s->P[column];
    for (int j = 0; j < N_P; ++j) {
      w[j] += h * row[j];
    }
  }
  for (int k = 0; k < WIDTH; ++k) {
    const int column = (int)columns[k];
    variance += phi[k] * p->scale[column] * w[column];
  }
  const double inverse = 1.0 / sqrt(variance);
  for (int j = 0; j < N_P; ++j) {
    w[j] *= inverse;
    s->q[j] += w[j] * inverse * error;
  }
  for (int i = 0; i < N_P; ++i) {
    const double w_i = w[i];
    double *row = s->P[i];
    for (int j = 0; j < N_P; ++j) {
      row[j] -= w_i * w[j];
    }
  }
}

static bool finite(const double *values, int count) {
  for (int k = 0; k < count; ++k) {
    if (!isfinite(values[k])) {
      return false;
    }
  }
  return true;
}

static void tick(const estimator_parameters *p, const estimator_inputs *u, void *memory,
                 estimator_outputs *y) {
  state *s = memory;
  s->ticks += 1.0;
  if (s->ticks * p->Ts < p->t_start) {
    return;
  }
  double phi[N * WIDTH];
  estimator_regressor(u->x, u->xd, u->xdd, u->chi_f, phi);
  if (!finite(phi, N * WIDTH)) {
    y->fault = FAULT_NOT_FINITE;
    return;
  }
  for (int k = 0; k < N_P; ++k) {
    s->P[k][k] += p->R1[k] * p->adapt[k];
  }
  for (int i = 0; i < N; ++i) {
    const double *row = phi + i * WIDTH, *columns = s->columns + i * WIDTH;
    y->innovation[i] = miss(p, s, row, columns, u->tau_f[i]);
  }
  for (int i = 0; i < N; ++i) {
    update(p, s, phi + i * WIDTH, s->columns + i * WIDTH, u->tau_f[i]);
  }
  publish(p, s, y);
  y->fault = 0.0;
}

FLEXHEX_ROOM(estimator, state, start, tick)
