/* Kalman filter of the normalised parameters q = p / scale, all torques of a tick at once.

   With H = Phi diag(scale), few nonzeros in a row, and S = H P H' + R2 I = L L':
     W = P H' L^-T,  q += W L^-1 (tau - Phi p),  P -= W W'
   Every element of W W' is summed in one order, so P stays symmetric to the last bit. */
#include "estimator.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 8 };
enum { N = ESTIMATOR_N, N_P = ESTIMATOR_N_P, WIDTH = ESTIMATOR_WIDTH };
static const double FAULT_NOT_FINITE = 2.0, FAULT_NO_COVARIANCE = 3.0;

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
  state *s = (state *)memory;
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

/* One row of the measurement: its nonzeros h, their columns, and the innovation. */
typedef struct {
  double h[WIDTH];
  int column[WIDTH];
  double innovation;
} measurement;

static void measure(const estimator_parameters *p, const state *s, const double *phi,
                    const double *columns, double tau, measurement *m) {
  m->innovation = tau;
  for (int k = 0; k < WIDTH; ++k) {
    m->column[k] = (int)columns[k];
    m->h[k] = phi[k] * p->scale[m->column[k]];
    m->innovation -= m->h[k] * s->q[m->column[k]];
  }
}

static double along(const measurement *m, const double *w) {
  double sum = 0.0;
  for (int k = 0; k < WIDTH; ++k) {
    sum += m->h[k] * w[m->column[k]];
  }
  return sum;
}

/* W[i] starts as P h_i; L and W are computed row by row. False when S is not positive definite. */
static bool factorise(const estimator_parameters *p, const state *s, const measurement *m,
                      double W[N][N_P], double *error) {
  double L[N][N];
  memset(W, 0, N * sizeof W[0]);
  for (int i = 0; i < N; ++i) {
    /* four rows of P at a time, added in their order: fewer passes over W */
    int k = 0;
    for (; k + 4 <= WIDTH; k += 4) {
      const double *h = m[i].h + k, *a = s->P[m[i].column[k]], *b = s->P[m[i].column[k + 1]];
      const double *c = s->P[m[i].column[k + 2]], *d = s->P[m[i].column[k + 3]];
      for (int j = 0; j < N_P; ++j) {
        W[i][j] = (((W[i][j] + h[0] * a[j]) + h[1] * b[j]) + h[2] * c[j]) + h[3] * d[j];
      }
    }
    for (; k < WIDTH; ++k) {
      const double h = m[i].h[k], *row = s->P[m[i].column[k]];
      for (int j = 0; j < N_P; ++j) {
        W[i][j] += h * row[j];
      }
    }
    double pivot = p->R2 + along(&m[i], W[i]);
    error[i] = m[i].innovation;
    for (int l = 0; l < i; ++l) {
      L[i][l] = along(&m[i], W[l]);
      pivot -= L[i][l] * L[i][l];
      error[i] -= L[i][l] * error[l];
      for (int j = 0; j < N_P; ++j) {
        W[i][j] -= L[i][l] * W[l][j];
      }
    }
    /* no less than R2 but for rounding, as long as P is positive semidefinite */
    if (!(pivot > 0.5 * p->R2)) {
      return false;
    }
    const double inverse = 1.0 / sqrt(pivot);
    error[i] *= inverse;
    for (int j = 0; j < N_P; ++j) {
      W[i][j] *= inverse;
    }
  }
  return true;
}

static void correct(state *s, double W[N][N_P], const double *error) {
  double unused[N_P] = {0.0};
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N_P; ++j) {
      s->q[j] += W[i][j] * error[i];
    }
  }
  /* rows in blocks, from the first column of the block on, two at a time; then the mirror image of
     a block while it is at hand */
  for (int block = 0; block < N_P; block += BLOCK) {
    const int end = block + BLOCK < N_P ? block + BLOCK : N_P;
    for (int i = block; i < end; i += 2) {
      const int other = i + 1 < N_P ? i + 1 : i;
      double *row = s->P[i], *next = i + 1 < N_P ? s->P[other] : unused;
      for (int j = block; j < N_P; ++j) {
        double sum = 0.0, more = 0.0;
        for (int m = 0; m < N; ++m) {
          sum += W[m][i] * W[m][j];
          more += W[m][other] * W[m][j];
        }
        row[j] -= sum;
        next[j] -= more;
      }
    }
    for (int j = block + BLOCK; j < N_P; ++j) {
      for (int k = 0; k < BLOCK; ++k) {
        s->P[j][block + k] = s->P[block + k][j];
      }
    }
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
  double W[N][N_P], error[N];
  for (int i = 0; i < N; ++i) {
    measure(p, s, phi + i * WIDTH, s->columns + i * WIDTH, u->tau_f[i], &m[i]);
    y->innovation[i] = m[i].innovation;
  }
  for (int k = 0; k < N_P; ++k) {
    s->P[k][k] += p->R1[k] * p->adapt[k];
  }
  if (!factorise(p, s, m, W, error)) {
    y->fault = FAULT_NO_COVARIANCE;
    return;
  }
  correct(s, W, error);
  publish(p, s, y);
  y->fault = 0.0;
}

FLEXHEX_ROOM(estimator, state, start, tick)
