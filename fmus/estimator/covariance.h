/* The update of the covariance P and of q by the rows of a measurement, in pairs of doubles or four
   at a time: same operations in the same order, same bits. */
#ifndef FLEXHEX_COVARIANCE_H
#define FLEXHEX_COVARIANCE_H

#include "pair.h"
#include "wide.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 8 };
enum { N = ESTIMATOR_N, N_P = ESTIMATOR_N_P, WIDTH = ESTIMATOR_WIDTH };
enum { ROWS = (N_P + BLOCK - 1) / BLOCK * BLOCK }; /* whole blocks; what is beyond N_P stays 0 */

typedef struct {
  double q[N_P];
  /* blocks left of the diagonal and on it; the others, their mirror image, stay zero */
  double P[ROWS][ROWS];
  double columns[N * WIDTH];
  double ticks;
} state;

/* One row of the measurement: its nonzeros h, their columns, and the innovation. */
typedef struct {
  double h[WIDTH];
  int column[WIDTH];
  double innovation;
} measurement;

/* W[i] = P h_i for all rows of the measurement, of BLOCK elements from j on. */
typedef void multiply(const state *s, const measurement *m, int j, double W[N][ROWS]);

static INLINE double along(const measurement *m, const double *w) {
  double sum = 0.0;
  for (int k = 0; k < WIDTH; ++k) {
    sum += m->h[k] * w[m->column[k]];
  }
  return sum;
}

static INLINE pair beside(double first, double second) {
  const pair both = {first, second};
  return both;
}

/* Over the columns of h in their order. The elements of P stand in a row where the column is not
   left of the block, else in its mirror image, a column. */
static INLINE void row_in_pairs(const state *s, const measurement *m, int j, double *w) {
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

static INLINE void in_pairs(const state *s, const measurement *m, int j, double W[N][ROWS]) {
  for (int i = 0; i < N; ++i) {
    row_in_pairs(s, &m[i], j, W[i] + j);
  }
}

#ifdef QUADS
/* h times eight elements of P, added to the sums of the first and of the last four. */
static INLINE QUADS void add(double h, const quad *one, const quad *two, quad *first, quad *last) {
  const quad all = {h, h, h, h};
  *first += all * *one;
  *last += all * *two;
}

/* What the k-th column of a row adds to a block. */
static INLINE QUADS void add_column(const state *s, const measurement *m, int k, int j, quad *first,
                                    quad *last) {
  const int column = m->column[k];
  if (column >= j) {
    const double *x = s->P[column] + j;
    const quad one = {x[0], x[1], x[2], x[3]}, two = {x[4], x[5], x[6], x[7]};
    add(m->h[k], &one, &two, first, last);
  } else {
    const double *x = s->P[j] + column;
    const quad one = {x[0], x[ROWS], x[2 * ROWS], x[3 * ROWS]};
    const quad two = {x[4 * ROWS], x[5 * ROWS], x[6 * ROWS], x[7 * ROWS]};
    add(m->h[k], &one, &two, first, last);
  }
}

/* Four neighbouring elements of four rows of P, column by column. */
static INLINE QUADS void turned(const double *x, quad column[4]) {
  quad a, b, c, d;
  memcpy(&a, x, sizeof a);
  memcpy(&b, x + ROWS, sizeof b);
  memcpy(&c, x + 2 * ROWS, sizeof c);
  memcpy(&d, x + 3 * ROWS, sizeof d);
  const quad e = MIXED(a, b, 0, 4, 2, 6), f = MIXED(a, b, 1, 5, 3, 7);
  const quad g = MIXED(c, d, 0, 4, 2, 6), h = MIXED(c, d, 1, 5, 3, 7);
  const quad one = MIXED(e, g, 0, 1, 4, 5), two = MIXED(f, h, 0, 1, 4, 5);
  const quad three = MIXED(e, g, 2, 3, 6, 7), four = MIXED(f, h, 2, 3, 6, 7);
  column[0] = one;
  column[1] = two;
  column[2] = three;
  column[3] = four;
}

/* What the k-th column and the three after it add. Neighbours left of the block are read together.
 */
static INLINE QUADS void add_four(const state *s, const measurement *m, int k, int j, quad *first,
                                  quad *last) {
  const int *at = m->column + k, column = at[0];
  if (at[3] < j && at[3] == column + 3 && at[2] == column + 2 && at[1] == column + 1) {
    const double *x = s->P[j] + column, *h = m->h + k;
    quad one[4], two[4];
    turned(x, one);
    turned(x + 4 * ROWS, two);
    add(h[0], &one[0], &two[0], first, last);
    add(h[1], &one[1], &two[1], first, last);
    add(h[2], &one[2], &two[2], first, last);
    add(h[3], &one[3], &two[3], first, last);
  } else {
    add_column(s, m, k, j, first, last);
    add_column(s, m, k + 1, j, first, last);
    add_column(s, m, k + 2, j, first, last);
    add_column(s, m, k + 3, j, first, last);
  }
}

/* Two rows at a time: one alone would wait for its own sums. */
static INLINE QUADS void in_quads(const state *s, const measurement *m, int j, double W[N][ROWS]) {
  for (int i = 0; i < N; i += 2) {
    const int next = i + 1 < N ? i + 1 : i;
    quad a = {0.0, 0.0, 0.0, 0.0}, b = a, c = a, d = a;
    int k = 0;
    for (; k + 4 <= WIDTH; k += 4) {
      add_four(s, &m[i], k, j, &a, &b);
      add_four(s, &m[next], k, j, &c, &d);
    }
    for (; k < WIDTH; ++k) {
      add_column(s, &m[i], k, j, &a, &b);
      add_column(s, &m[next], k, j, &c, &d);
    }
    memcpy(W[i] + j, &a, sizeof a);
    memcpy(W[i] + j + 4, &b, sizeof b);
    memcpy(W[next] + j, &c, sizeof c);
    memcpy(W[next] + j + 4, &d, sizeof d);
  }
}
#endif

/* W[i] starts as P h_i; L and W are computed row by row. False when S is not positive definite. */
static INLINE bool factorise(const estimator_parameters *p, const state *s, const measurement *m,
                             multiply *multiplied, double W[N][ROWS], double *error) {
  double L[N][N];
  /* block by block: what several rows of H need of P is then still at hand */
  for (int j = 0; j < ROWS; j += BLOCK) {
    multiplied(s, m, j, W);
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

static INLINE void correct(state *s, double W[N][ROWS], const double *error) {
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

static INLINE bool updated(const estimator_parameters *p, state *s, const measurement *m,
                           multiply *multiplied) {
  double W[N][ROWS], error[N];
  if (!factorise(p, s, m, multiplied, W, error)) {
    return false;
  }
  correct(s, W, error);
  return true;
}

static bool updated_in_pairs(const estimator_parameters *p, state *s, const measurement *m) {
  return updated(p, s, m, in_pairs);
}

#ifdef QUADS
static QUADS bool updated_in_quads(const estimator_parameters *p, state *s, const measurement *m) {
  return updated(p, s, m, in_quads);
}
#endif

#endif
