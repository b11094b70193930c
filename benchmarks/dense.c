/* The paper's own step N: prediction (28), then (29), (14)-(17) by general 31 x 31 solves.

   The rival is to be fair: D, D_d, D_theta and the curvature are straight-line code from the same
   generator as ours; one factorisation at the predicted pose, one at the corrected pose, each
   used for all right-hand sides. Matrices are column-major, as CasADi writes them. */
#include "dense.h"

#include <math.h>
#include <string.h>

enum { N = DENSE_N, N_D = DENSE_N_D, N_X = N + N_D };

/* LU with partial pivoting in place; row[k]: which row was exchanged with k. */
static void factorise(double A[N_D][N_D], int row[N_D]) {
  for (int k = 0; k < N_D; ++k) {
    int best = k;
    for (int i = k + 1; i < N_D; ++i) {
      best = fabs(A[k][i]) > fabs(A[k][best]) ? i : best;
    }
    row[k] = best;
    for (int j = 0; best != k && j < N_D; ++j) {
      const double swapped = A[j][k];
      A[j][k] = A[j][best];
      A[j][best] = swapped;
    }
    const double inverse = 1.0 / A[k][k];
    for (int i = k + 1; i < N_D; ++i) {
      A[k][i] *= inverse;
    }
    for (int j = k + 1; j < N_D; ++j) {
      const double factor = A[j][k];
      for (int i = k + 1; i < N_D; ++i) {
        A[j][i] -= factor * A[k][i];
      }
    }
  }
}

static void solve(double A[N_D][N_D], const int row[N_D], double *b) {
  for (int k = 0; k < N_D; ++k) {
    const double swapped = b[k];
    b[k] = b[row[k]];
    b[row[k]] = swapped;
  }
  for (int k = 0; k < N_D; ++k) {
    for (int i = k + 1; i < N_D; ++i) {
      b[i] -= A[k][i] * b[k];
    }
  }
  for (int k = N_D - 1; k >= 0; --k) {
    b[k] /= A[k][k];
    for (int i = 0; i < k; ++i) {
      b[i] -= A[k][i] * b[k];
    }
  }
}

/* b = -(D_theta rate + more) */
static void gather(double D_theta[N][N_D], const double *rate, const double *more, double *b) {
  for (int i = 0; i < N_D; ++i) {
    b[i] = -more[i];
  }
  for (int j = 0; j < N; ++j) {
    for (int i = 0; i < N_D; ++i) {
      b[i] -= D_theta[j][i] * rate[j];
    }
  }
}

static void dense_step(const dense_inputs *u, dense_outputs *y, double Ts) {
  static const double nothing[N_D];
  double A[N_D][N_D], D_theta[N][N_D], D[N_D], curvature[N_D];
  int row[N_D];
  memcpy(y->x, u->theta, sizeof u->theta);
  for (int k = N; k < N_X; ++k) {
    y->x[k] += Ts * (y->xd[k] + Ts / 2 * y->xdd[k]);
  }
  dense_newton(y->x, D, (double *)A);
  factorise(A, row);
  solve(A, row, D);
  for (int k = 0; k < N_D; ++k) {
    y->x[N + k] -= D[k];
  }
  dense_rates(y->x, D, (double *)A, (double *)D_theta);
  factorise(A, row);
  memcpy(y->xd, u->thetad, sizeof u->thetad);
  gather(D_theta, u->thetad, nothing, y->xd + N);
  solve(A, row, y->xd + N);
  dense_curvature(y->x, y->xd, curvature);
  memcpy(y->xdd, u->thetadd, sizeof u->thetadd);
  gather(D_theta, u->thetadd, curvature, y->xdd + N);
  solve(A, row, y->xdd + N);
  double sum = 0.0;
  for (int k = 0; k < N_D; ++k) {
    sum += D[k] * D[k];
  }
  y->residual = sqrt(sum);
}

typedef struct {
  double unused;
} state;

static bool start(const dense_parameters *p, void *s, dense_outputs *y, char *message,
                  size_t size) {
  (void)p, (void)s, (void)message, (void)size;
  memset(y, 0, sizeof *y);
  dense_neutral(y->x);
  return true;
}

static void tick(const dense_parameters *p, const dense_inputs *u, void *s, dense_outputs *y) {
  (void)s;
  dense_step(u, y, p->Ts);
}

FLEXHEX_BLOCK(dense, state, start, tick)
