/* Kalman filter of the normalised parameters q = p / scale, all torques of a tick at once.

   With H = Phi diag(scale), few nonzeros in a row, and S = H P H' + R2 I = L L':
     W = P H' L^-T,  q += W L^-1 (tau - Phi p),  P -= W W'
   P is symmetric; what lies right of its blocks on the diagonal is neither kept nor read. */
#include "estimator.h"

#include "pair.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 8 };
enum { N = ESTIMATOR_N, N_P = ESTIMATOR_N_P, WIDTH = ESTIMATOR_WIDTH };
enum { ROWS = (N_P + BLOCK - 1) / BLOCK * BLOCK }; /* whole blocks; what is beyond N_P stays 0 */
static const double FAULT_NOT_FINITE = 2.0, FAULT_NO_COVARIANCE = 3.0;

typedef struct {
  double q[N_P];
  /* blocks left of the diagonal and on it; the others, their mirror image, stay zero */
  double P[ROWS][ROWS];
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

static inline pair beside(double first, double second) {
  const pair both = {first, second};
  return both;
}

/* Eight elements of w = P h from j on, over the columns of h in their order. The elements of P
   stand in a row where the column is not left of the block, else in its mirror image, a column. */
static void multiply(const state *s, const measurement *m, int j, double *w) {
  pair a = {0.0, 0.0}, b = a, c = a, d = a;
  for (int k = 0; k < WIDTH; ++k) {
    const pair h = beside(m->h[k], m->h[k]);
    const int column = m->column[k];
    if (column >= j) {
      const double *x = s->P[column] + j;
      a = ADD(a, MUL(h, beside(x[0], x[1])));
      b = ADD(b, MUL(h, beside(x[2], x[3])));
      c = ADD(c, MUL(h, beside(x[4], x[5])));
      d = ADD(d, MUL(h, beside(x[6], x[7])));
    } else {
      const double *x = s->P[j] + column;
      a = ADD(a, MUL(h, beside(x[0], x[ROWS])));
      b = ADD(b, MUL(h, beside(x[2 * ROWS], x[3 * ROWS])));
      c = ADD(c, MUL(h, beside(x[4 * ROWS], x[5 * ROWS])));
      d = ADD(d, MUL(h, beside(x[6 * ROWS], x[7 * ROWS])));
    }
  }
  const double block[BLOCK] = {FIRST(a), SECOND(a), FIRST(b), SECOND(b),
                               FIRST(c), SECOND(c), FIRST(d), SECOND(d)};
  memcpy(w, block, sizeof block);
}

/* W[i] starts as P h_i; L and W are computed row by row. False when S is not positive definite. */
static bool factorise(const estimator_parameters *p, const state *s, const measurement *m,
                      double W[N][ROWS], double *error) {
  double L[N][N];
  /* block by block: what several rows of H need of P is then still at hand */
  for (int j = 0; j < ROWS; j += BLOCK) {
    for (int i = 0; i < N; ++i) {
      multiply(s, &m[i], j, W[i] + j);
    }
  }
  for (int i = 0; i < N; ++i) {
    double pivot = p->R2 + along(&m[i], W[i]);
    error[i] = m[i].innovation;
    for (int l = 0; l < i; ++l) {
      L[i][l] = along(&m[i], W[l]);
      pivot -= L[i][l] * L[i][l];
      error[i] -= L[i][l] * error[l];
      for (int j = 0; j < ROWS; ++j) {
        W[i][j] -= L[i][l] * W[l][j];
      }
    }
    /* no less than R2 but for rounding, as long as P is positive semidefinite */
    if (!(pivot > 0.5 * p->R2)) {
      return false;
    }
    const double inverse = 1.0 / sqrt(pivot);
    error[i] *= inverse;
    for (int j = 0; j < ROWS; ++j) {
      W[i][j] *= inverse;
    }
  }
  return true;
}

static void correct(state *s, double W[N][ROWS], const double *error) {
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N_P; ++j) {
      s->q[j] += W[i][j] * error[i];
    }
  }
  /* rows as far as their block on the diagonal, two at a time */
  for (int i = 0; i < N_P; i += 2) {
    double *row = s->P[i], *next = s->P[i + 1];
    for (int j = 0; j < (i / BLOCK + 1) * BLOCK; ++j) {
      double sum = W[0][i] * W[0][j], more = W[0][i + 1] * W[0][j];
      for (int m = 1; m < N; ++m) {
        sum += W[m][i] * W[m][j];
        more += W[m][i + 1] * W[m][j];
      }
      row[j] -= sum;
      next[j] -= more;
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
  double W[N][ROWS], error[N];
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

FLEXHEX_BLOCK(estimator, state, start, tick)
