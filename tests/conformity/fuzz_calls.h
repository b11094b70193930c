/* The calls that the fuzzer makes: each draws its arguments, makes one call and says which answer
   the standard wants. */
#ifndef FUZZ_CALLS_H
#define FUZZ_CALLS_H

#include <stdio.h>
#include <string.h>

#include "fmi.h"
#include "fuzz.h"

enum { STATES = 3, MOST = 8, I = 1, M = 2, C = 4, T = 8 };

typedef struct {
  fmi2Component c;
  int phase;
  bool started; /* fmi2ExitInitializationMode was tried with these parameters */
  fmi2FMUstate states[STATES];
  int phases[STATES];
} subject;

static void fail(const char *what, long call) {
  printf("broken %s in call %ld\n", what, call);
  exit(1);
}

static fmi2Status get(const subject *s, int t, const fmi2ValueReference *vr, size_t n, double *real,
                      int *whole) {
  return t == FLEXHEX_REAL      ? fmi2GetReal(s->c, vr, n, real)
         : t == FLEXHEX_INTEGER ? fmi2GetInteger(s->c, vr, n, whole)
                                : fmi2GetBoolean(s->c, vr, n, whole);
}

static fmi2Status set_all(const subject *s, int t, const fmi2ValueReference *vr, size_t n,
                          const double *real, const int *whole) {
  return t == FLEXHEX_REAL      ? fmi2SetReal(s->c, vr, n, real)
         : t == FLEXHEX_INTEGER ? fmi2SetInteger(s->c, vr, n, whole)
                                : fmi2SetBoolean(s->c, vr, n, whole);
}

/* Wanted answers: 1 good, 0 refused, -1 good or refused. */
static int values(subject *s, bool set, fmi2Status *status) {
  fmi2ValueReference vr[MOST];
  double value[MOST];
  int whole[MOST];
  const int t = below(3) ? FLEXHEX_REAL : (int)below(3);
  const unsigned count = n_of_type[t];
  const unsigned n = count ? below(MOST + 1) : 0, start = below(count ? count : 1);
  bool good = true;
  for (unsigned k = 0; k < n; ++k) {
    vr[k] = of_type[t][below(3) ? (start + k) % count : below(count)];
    if (below(400) == 0) {
      vr[k] = below(n_values); /* perhaps of another type */
    }
    if (below(200) == 0) {
      vr[k] = below(2) ? 0xffffffffu : n_values + below(3);
    }
    const bool known = vr[k] < n_values && type[vr[k]] == t;
    value[k] = known ? number(vr[k]) : 0.0;
    whole[k] = t == FLEXHEX_REAL ? 0 : (int)value[k];
    const bool allowed = known && (kind[vr[k]] == FLEXHEX_INPUT || kind[vr[k]] == FLEXHEX_TUNABLE ||
                                   (kind[vr[k]] == FLEXHEX_FIXED && s->phase != C));
    good = good && (set ? allowed && in_range(vr[k], value[k]) : known);
  }
  const bool null = below(100) == 0;
  good = good && (!null || n == 0);
  *status = set ? set_all(s, t, null ? NULL : vr, n, value, whole)
                : get(s, t, null ? NULL : vr, n, value, whole);
  const bool legal = set ? s->phase != T : s->phase != I;
  if (!set && s->phase == M && good) {
    return -1; /* first outputs of parameters that the block may refuse */
  }
  if (!set && *status == fmi2OK) {
    for (unsigned k = 0; k < n; ++k) {
      if (!isfinite(value[k])) {
        fail("value that is not finite", (long)vr[k]);
      }
    }
  }
  return legal && good;
}

static int step(subject *s, fmi2Status *status) {
  const double sizes[] = {0.0, -1.0, NAN, INFINITY, 1e300, 0.5, 1.5, -INFINITY, 0.3};
  const double rest = 1e-17; /* of a base step: what sums of times leave over */
  double now = 0.0, size = below(9) ? 1 + below(8) : 121 + below(200);
  bool good = s->phase == C && fmi2GetRealStatus(s->c, fmi2LastSuccessfulTime, &now) == fmi2OK;
  if (below(8) == 0) {
    size = sizes[below(sizeof sizes / sizeof *sizes)];
    good = false;
  }
  if (below(16) == 0) {
    now += (below(2) ? 1 : -1) * (1 + below(5)) * FLEXHEX_MODEL.base_step;
    good = false;
  }
  if (good && below(8) == 0) {
    *status = fmi2DoStep(s->c, now, rest * FLEXHEX_MODEL.base_step, fmi2True);
    return 1;
  }
  *status = fmi2DoStep(s->c, now, size * FLEXHEX_MODEL.base_step, fmi2True);
  return good ? -1 : 0; /* a stop time may be in the way */
}

static int state_call(subject *s, unsigned which, fmi2Status *status) {
  const unsigned k = below(STATES);
  size_t size = 0;
  fmi2FMUstate copy = NULL;
  switch (which) {
    case 0:
      *status = fmi2GetFMUstate(s->c, &s->states[k]);
      s->phases[k] = s->phase;
      return 1;
    case 1: {
      const int good = s->states[k] != NULL;
      *status = fmi2SetFMUstate(s->c, s->states[k]);
      s->phase = good ? s->phases[k] : s->phase;
      return good;
    }
    case 2:
      *status = fmi2FreeFMUstate(s->c, &s->states[k]);
      return 1;
    default:;
  }
  if (!s->states[k] || fmi2SerializedFMUstateSize(s->c, s->states[k], &size) != fmi2OK) {
    *status = fmi2SerializedFMUstateSize(s->c, NULL, &size);
    return 0;
  }
  fmi2Byte *bytes = malloc(size);
  *status = fmi2SerializeFMUstate(s->c, s->states[k], bytes, size);
  const bool spoil = below(2), cut = below(2);
  if (spoil && !cut) {
    bytes[below((unsigned)size)] ^= (fmi2Byte)(1 << below(7));
  }
  const size_t shown = spoil && cut ? below((unsigned)size) : size;
  const fmi2Status read = fmi2DeSerializeFMUstate(s->c, bytes, shown, &copy);
  if ((read == fmi2OK) == spoil) {
    fail("serialised state", (long)shown);
  }
  if (copy && fmi2FreeFMUstate(s->c, &copy) != fmi2OK) {
    fail("copy cannot be freed", 0);
  }
  free(bytes);
  return 1;
}

static int setup(subject *s, fmi2Status *status) {
  const double times[] = {0.0, 0.0, 0.0, -3.0, 1e6, NAN, INFINITY, 1e300};
  const double from = times[below(8)], to = times[below(8)];
  const fmi2Boolean stops = below(4) == 0;
  *status = fmi2SetupExperiment(s->c, fmi2False, 0.0, from, stops, to);
  return s->phase == I && fabs(from) <= 1e6 && (!stops || to >= from);
}

static int logging(subject *s, fmi2Status *status) {
  const fmi2String names[] = {"logEvents", "logStatusWarning", "logAll", NULL};
  const unsigned k = below(4), n = below(2);
  *status = fmi2SetDebugLogging(s->c, below(8) == 0, n, names + k);
  return n == 0 || k < 2;
}

/* One function in `state` with a NULL or an unknown status kind now and then */
static int status_call(subject *s, unsigned which, fmi2Status *status) {
  const fmi2StatusKind kind = (fmi2StatusKind)below(4);
  fmi2Status own = fmi2OK;
  fmi2Real real = 0.0;
  fmi2Integer whole = 0;
  fmi2Boolean flag = 0;
  fmi2String text = NULL;
  const bool null = below(10) == 0;
  switch (which) {
    case 0:
      *status = fmi2GetStatus(s->c, kind, null ? NULL : &own);
      break;
    case 1:
      *status = fmi2GetRealStatus(s->c, kind, null ? NULL : &real);
      break;
    case 2:
      *status = fmi2GetIntegerStatus(s->c, kind, null ? NULL : &whole);
      break;
    case 3:
      *status = fmi2GetBooleanStatus(s->c, kind, null ? NULL : &flag);
      break;
    default:
      *status = fmi2GetStringStatus(s->c, kind, null ? NULL : &text);
      break;
  }
  if (!null && (s->phase == C || s->phase == T)) {
    return *status == fmi2Discard ? -1 : 1;
  }
  return 0;
}

/* Functions for which there is nothing here: fine for nothing, refused for something */
static int empty_call(subject *s, unsigned which, fmi2Status *status) {
  const fmi2ValueReference vr[1] = {below(n_values)};
  fmi2Integer whole[1] = {1};
  fmi2String text[1] = {"x"};
  double real[1] = {0.0};
  const size_t n = below(2);
  switch (which) {
    case 0:
      *status = fmi2GetString(s->c, vr, n, text);
      return n == 0 && s->phase != I;
    case 1:
      *status = fmi2SetString(s->c, vr, n, text);
      return n == 0 && s->phase != T;
    case 2:
      *status = fmi2SetRealInputDerivatives(s->c, vr, n, whole, real);
      return n == 0 && s->phase != T;
    case 3:
      *status = fmi2GetRealOutputDerivatives(s->c, vr, n, whole, real);
      return n == 0 && (s->phase == C || s->phase == T);
    case 4:
      *status = fmi2GetDirectionalDerivative(s->c, vr, n, vr, n, real, real);
      return n == 0 && s->phase != I;
    default:
      *status = fmi2CancelStep(s->c);
      return 0;
  }
}

/* The phases follow one another; the later ones are left seldom. */
static int phase_call(subject *s, unsigned which, fmi2Status *status) {
  int wanted = 0;
  switch (which) {
    case 0:
      *status = fmi2EnterInitializationMode(s->c);
      wanted = s->phase == I;
      s->phase = wanted ? M : s->phase;
      return wanted;
    case 1:
      *status = fmi2ExitInitializationMode(s->c);
      wanted = s->phase == M ? -1 : 0;
      s->phase = wanted && *status == fmi2OK ? C : s->phase;
      return wanted;
    case 2:
      *status = fmi2Terminate(s->c);
      wanted = s->phase == C;
      s->phase = wanted ? T : s->phase;
      return wanted;
    default:
      *status = fmi2Reset(s->c);
      s->phase = I;
      return 1;
  }
}

#endif
