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
#include "fuzz_calls.h"

enum { INSTANCES = 2 };

static subject subjects[INSTANCES];
static long refusals, messages;
static double *before, *after;

static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
  (void)environment, (void)status;
  messages += (long)(strlen(name) + strlen(category) + strlen(message) > 0);
}

/* All values; false in the states in which they cannot be read. */
static bool look(const subject *s, double *values) {
  if (s->phase != C && s->phase != T) {
    return false;
  }
  static int *whole;
  static double *real;
  whole = whole ? whole : malloc(n_values * sizeof *whole);
  real = real ? real : malloc(n_values * sizeof *real);
  for (int t = 0; t < 3; ++t) {
    if (get(s, t, of_type[t], n_of_type[t], real, whole) != fmi2OK) {
      return false;
    }
    for (unsigned k = 0; k < n_of_type[t]; ++k) {
      values[of_type[t][k]] = t == FLEXHEX_REAL ? real[k] : whole[k];
    }
  }
  return true;
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
    return empty_call(s, below(6), status);
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
    const unsigned n = n_values - 1;
    if (memcmp(before, after, n * sizeof *before) != 0 || after[n] == 0.0) {
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
