/* What the fuzzer draws from: a generator, and what the FMU's table says of its variables. */
#ifndef FUZZ_H
#define FUZZ_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "flexhex_config.h"
#include "model.h"

static uint64_t seed;
static unsigned n_values;
static double *low, *high, *first;
static int *kind, *type;
static unsigned *of_type[3], n_of_type[3]; /* references by type */

/* xorshift, 64 bits (Marsaglia) */
static uint64_t draw(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return seed;
}

static unsigned below(unsigned n) {
  return (unsigned)(draw() >> 33) % n;
}

static double number(unsigned vr) {
  const double odd[] = {NAN,   INFINITY, -INFINITY, 0.0,
                        -0.0,  DBL_MAX,  -1e9,      5e-324,
                        1e300, low[vr],  high[vr],  nextafter(high[vr], INFINITY)};
  const unsigned choice = below(240);
  if (type[vr] == FLEXHEX_BOOLEAN) {
    return choice < 4 ? (double)choice - 1.0 : below(2);
  }
  if (type[vr] == FLEXHEX_INTEGER) {
    return first[vr] + (choice < 20 ? (double)below(2000001) - 1e6 : (double)below(5) - 2.0);
  }
  if (choice < sizeof odd / sizeof *odd) {
    return odd[choice];
  }
  const double width = fmin(high[vr] - low[vr], 1.0 + fabs(first[vr]));
  return first[vr] + width * ((double)below(2001) - 1000.0) * (choice < 200 ? 1e-5 : 1e-3);
}

static bool in_range(unsigned vr, double value) {
  return isfinite(value) && value >= low[vr] && value <= high[vr];
}

static void describe(void) {
  const flexhex_model *model = &FLEXHEX_MODEL;
  n_values = (unsigned)model->n_values;
  double **tables[] = {&low, &high, &first};
  for (size_t k = 0; k < sizeof tables / sizeof *tables; ++k) {
    *tables[k] = calloc(n_values, sizeof(double));
  }
  kind = calloc(n_values, sizeof *kind);
  type = calloc(n_values, sizeof *type);
  for (int k = 0; k < 3; ++k) {
    of_type[k] = calloc(n_values, sizeof *of_type[k]);
  }
  unsigned vr = 0;
  for (int k = 0; k < model->n_variables; ++k) {
    const flexhex_variable *v = &model->variables[k];
    for (int i = 0; i < (v->size ? v->size : 1); ++i, ++vr) {
      low[vr] = v->least ? v->least[i] : v->min;
      high[vr] = v->max;
      kind[vr] = (int)v->kind;
      type[vr] = (int)v->type;
      of_type[v->type][n_of_type[v->type]++] = vr;
      first[vr] = model->starts[vr];
    }
  }
}

#endif
