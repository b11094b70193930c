/* A rival for the adapter: 100 inputs, 100 outputs, one case of a switch for each value
   reference, one call for each value, a doStep that compares times in floating point. Checks
   neither ranges nor finiteness nor the instance's state, which the house's adapter does. */
#include <stddef.h>

#include "fmi2FunctionTypes.h"

#define EXPORT __attribute__((visibility("default")))
/* clang-format off */
#define TEN(X, t) X(t##0) X(t##1) X(t##2) X(t##3) X(t##4) X(t##5) X(t##6) X(t##7) X(t##8) X(t##9)
#define HUNDRED(X)                                             \
  X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9)            \
  TEN(X, 1) TEN(X, 2) TEN(X, 3) TEN(X, 4) TEN(X, 5) TEN(X, 6)  \
  TEN(X, 7) TEN(X, 8) TEN(X, 9)
#define FIELDS(k) double u##k, y##k;
#define SET(k) case k: m->u##k = value; return fmi2OK;
#define GET(k) case 100 + k: *value = m->y##k; return fmi2OK;
/* clang-format on */

typedef struct {
  double time, next;
  HUNDRED(FIELDS)
} model;

static model the_model;

EXPORT void *switching_instance(void);
EXPORT fmi2Status switching_set(fmi2Component c, const fmi2ValueReference *vr, size_t n,
                                const fmi2Real *value);
EXPORT fmi2Status switching_get(fmi2Component c, const fmi2ValueReference *vr, size_t n,
                                fmi2Real *value);
EXPORT fmi2Status switching_step(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final);

void *switching_instance(void) {
  the_model.next = 1e300;
  return &the_model;
}

static fmi2Status set_one(model *m, fmi2ValueReference vr, double value) {
  switch (vr) {
    HUNDRED(SET)
    default:
      return fmi2Error;
  }
}

static fmi2Status get_one(const model *m, fmi2ValueReference vr, double *value) {
  switch (vr) {
    HUNDRED(GET)
    default:
      return fmi2Error;
  }
}

fmi2Status switching_set(fmi2Component c, const fmi2ValueReference *vr, size_t n,
                         const fmi2Real *value) {
  for (size_t k = 0; k < n; ++k) {
    if (set_one(c, vr[k], value[k]) != fmi2OK) {
      return fmi2Error;
    }
  }
  return fmi2OK;
}

fmi2Status switching_get(fmi2Component c, const fmi2ValueReference *vr, size_t n, fmi2Real *value) {
  for (size_t k = 0; k < n; ++k) {
    if (get_one(c, vr[k], &value[k]) != fmi2OK) {
      return fmi2Error;
    }
  }
  return fmi2OK;
}

fmi2Status switching_step(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
  model *m = c;
  (void) final;
  m->time = t;
  while (m->time + 1e-12 < t + h) {
    m->time += h;
    if (m->time >= m->next) {
      m->y0 = m->u0;
    }
  }
  return fmi2OK;
}
