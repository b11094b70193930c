/* Calls every function of an FMU at random, with good and bad arguments, and checks each answer
   against the call table, the ranges and the promise that a refused call changes nothing.

   Compiled with the FMU's own sources and sanitizers; `fuzz SEED CALLS` prints the number of calls
   and of refusals, or the first broken promise and exits with 1. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "flexhex_config.h"
#include "fmi.h"
#include "fuzz.h"

enum { INSTANCES = 2, STATES = 3, MOST = 8, I = 1, M = 2, C = 4, T = 8 };

typedef struct {
  fmi2Component c;
  int phase;
  bool started; /* fmi2ExitInitializationMode was tried with these parameters */
  fmi2FMUstate states[STATES];
  int phases[STATES];
} subject;

static subject subjects[INSTANCES];
static long refusals, messages;
static double *before, *after;

static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
  (void)environment, (void)status;
  messages += (long)(strlen(name) + strlen(category) + strlen(message) > 0);
}

static void fail(const char *what, long call) {
  printf("broken %s in call %ld\n", what, call);
  exit(1);
}

/* All values; false in the states in which they cannot be read. */
static bool look(const subject *s, double *values) {
  if (s->phase != C && s->phase != T) {
    return false;
  }
  static fmi2ValueReference *all;
  if (!all) {
    all = malloc(n_values * sizeof *all);
    for (unsigned k = 0; k < n_values; ++k) {
      all[k] = k;
    }
  }
  return fmi2GetReal(s->c, all, n_values, values) == fmi2OK;
}

static fmi2Component make(void) {
  static const fmi2CallbackFunctions own = {hear, calloc, free, NULL, NULL},
                                     none = {hear, NULL, NULL, NULL, NULL};
  const bool wrong = below(20) == 0;
  fmi2Component c = fmi2Instantiate(wrong ? "" : "one%s#", fmi2CoSimulation, FLEXHEX_MODEL.guid,
                                    NULL, below(2) ? &own : &none, fmi2False, below(4) == 0);
  if (wrong && c) {
    fail("instantiated without a name", -1);
  }
  return c;
}

static void drop(subject *s) {
  for (int k = 0; k < STATES; ++k) {
    if (fmi2FreeFMUstate(s->c, &s->states[k]) != fmi2OK) {
      fail("state cannot be freed", -1);
    }
  }
  fmi2FreeInstance(s->c);
  memset(s, 0, sizeof *s);
}

/* Wanted answers: 1 good, 0 refused, -1 either. */
static int values(subject *s, bool set, fmi2Status *status) {
  fmi2ValueReference vr[MOST];
  double value[MOST];
  const unsigned n = below(MOST + 1), start = below(n_values);
  bool good = true;
  for (unsigned k = 0; k < n; ++k) {
    vr[k] = below(3) ? (start + k) % n_values : below(n_values);
    if (below(200) == 0) {
      vr[k] = below(2) ? 0xffffffffu : n_values + below(3);
    }
    const bool known = vr[k] < n_values;
    value[k] = known ? number(vr[k]) : 0.0;
    const bool allowed = known && (kind[vr[k]] == FLEXHEX_INPUT || kind[vr[k]] == FLEXHEX_TUNABLE ||
                                   (kind[vr[k]] == FLEXHEX_FIXED && s->phase != C));
    good = good && (set ? allowed && in_range(vr[k], value[k]) : known);
  }
  const bool null = below(100) == 0;
  good = good && (!null || n == 0);
  *status = set ? fmi2SetReal(s->c, null ? NULL : vr, n, value)
                : fmi2GetReal(s->c, null ? NULL : vr, n, value);
  const bool legal = set ? s->phase != T : s->phase != I;
  if (!set && s->phase == M && good) {
    return -1; /* first outputs of parameters that the room may refuse */
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
  const double sizes[] = {0.0, -1.0, NAN, INFINITY, 1e300, 0.5, 1.5, -INFINITY, 1e-9};
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
    default:
      break;
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
  const fmi2StatusKind asked = (fmi2StatusKind)below(4);
  fmi2Status own = fmi2OK;
  fmi2Real real = 0.0;
  fmi2Integer whole = 0;
  fmi2Boolean flag = 0;
  fmi2String text = NULL;
  const bool null = below(10) == 0;
  switch (which) {
    case 0:
      *status = fmi2GetStatus(s->c, asked, null ? NULL : &own);
      break;
    case 1:
      *status = fmi2GetRealStatus(s->c, asked, null ? NULL : &real);
      break;
    case 2:
      *status = fmi2GetIntegerStatus(s->c, asked, null ? NULL : &whole);
      break;
    case 3:
      *status = fmi2GetBooleanStatus(s->c, asked, null ? NULL : &flag);
      break;
    default:
      *status = fmi2GetStringStatus(s->c, asked, null ? NULL : &text);
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
      *status = fmi2GetInteger(s->c, vr, n, whole);
      return n == 0 && s->phase != I;
    case 1:
      *status = fmi2GetBoolean(s->c, vr, n, whole);
      return n == 0 && s->phase != I;
    case 2:
      *status = fmi2GetString(s->c, vr, n, text);
      return n == 0 && s->phase != I;
    case 3:
      *status = fmi2SetInteger(s->c, vr, n, whole);
      return n == 0 && s->phase != T;
    case 4:
      *status = fmi2SetBoolean(s->c, vr, n, whole);
      return n == 0 && s->phase != T;
    case 5:
      *status = fmi2SetString(s->c, vr, n, text);
      return n == 0 && s->phase != T;
    case 6:
      *status = fmi2SetRealInputDerivatives(s->c, vr, n, whole, real);
      return n == 0 && s->phase != T;
    case 7:
      *status = fmi2GetRealOutputDerivatives(s->c, vr, n, whole, real);
      return n == 0 && (s->phase == C || s->phase == T);
    case 8:
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

static int any_call(subject *s, fmi2Status *status) {
  const unsigned choice = below(1000);
  if (choice < 330) {
    return step(s, status);
  }
  if (choice < 580) {
    return values(s, true, status);
  }
  if (choice < 720) {
    return values(s, false, status);
  }
  if (choice < 750) {
    return state_call(s, below(4), status);
  }
  if (choice < 800) {
    return status_call(s, below(5), status);
  }
  if (choice < 850) {
    return empty_call(s, below(10), status);
  }
  if (choice < 870) {
    return logging(s, status);
  }
  if (choice < 890) {
    return setup(s, status);
  }
  if (choice < 990) {
    return phase_call(s, s->phase == T && below(4) == 0 ? 3 : below(2), status);
  }
  return phase_call(s, 2 + below(2), status);
}

static void one_call(long call) {
  subject *s = &subjects[below(INSTANCES)];
  if (!s->c) {
    s->c = make();
    s->phase = I;
    return;
  }
  if (below(3000) == 0) {
    drop(s);
    return;
  }
  const bool seen = call % 8 == 0 && look(s, before);
  const int phase = s->phase;
  fmi2Status status = fmi2Fatal;
  const int wanted = any_call(s, &status);
  refusals += status == fmi2Error;
  if (status > fmi2Error || (wanted == 1 && status != fmi2OK) ||
      (wanted == 0 && status != fmi2Error)) {
    fail("answer", call);
  }
  if (seen && status == fmi2Error && s->phase == phase && look(s, after)) {
    /* all but the last, fault, are as before */
    if (memcmp(before, after, (n_values - 1) * sizeof *before) != 0 || after[n_values - 1] == 0.0) {
      fail("promise that a refused call changes nothing but fault", call);
    }
  }
}

int main(int count, char **arguments) {
  if (count != 3) {
    return 2;
  }
  seed = strtoull(arguments[1], NULL, 10) * UINT64_C(0x9e3779b97f4a7c15) + 1;
  const long calls = strtol(arguments[2], NULL, 10);
  describe();
  before = calloc(n_values, sizeof *before);
  after = calloc(n_values, sizeof *after);
  for (long call = 0; call < calls; ++call) {
    one_call(call);
  }
  for (int k = 0; k < INSTANCES; ++k) {
    if (subjects[k].c) {
      drop(&subjects[k]);
    }
  }
  free(before), free(after), free(low), free(high), free(first), free(kind);
  printf("calls %ld refusals %ld messages %ld\n", calls, refusals, messages);
  return 0;
}
