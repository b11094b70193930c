/* Two FMUs in one program: counts allocations, measures an idle step, tries every function once.

   Built with -DFLEXHEX_STATIC sources of toy and toy_two; prints `name value` lines. With
   -DHARNESS_SANITIZED the allocator is left to the sanitizer. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define DECLARE(id)                                                        \
  extern fmi2InstantiateTYPE id##_fmi2Instantiate;                         \
  extern fmi2FreeInstanceTYPE id##_fmi2FreeInstance;                       \
  extern fmi2EnterInitializationModeTYPE id##_fmi2EnterInitializationMode; \
  extern fmi2ExitInitializationModeTYPE id##_fmi2ExitInitializationMode;   \
  extern fmi2ResetTYPE id##_fmi2Reset;                                     \
  extern fmi2GetRealTYPE id##_fmi2GetReal;                                 \
  extern fmi2SetRealTYPE id##_fmi2SetReal;                                 \
  extern fmi2DoStepTYPE id##_fmi2DoStep;                                   \
  extern fmi2GetFMUstateTYPE id##_fmi2GetFMUstate;                         \
  extern fmi2SetFMUstateTYPE id##_fmi2SetFMUstate;                         \
  extern fmi2FreeFMUstateTYPE id##_fmi2FreeFMUstate;                       \
  extern fmi2SerializedFMUstateSizeTYPE id##_fmi2SerializedFMUstateSize;   \
  extern fmi2SerializeFMUstateTYPE id##_fmi2SerializeFMUstate;             \
  extern fmi2DeSerializeFMUstateTYPE id##_fmi2DeSerializeFMUstate;
DECLARE(toy)
DECLARE(toy_two)

#ifdef HARNESS_SANITIZED
static long allocations;
#else
enum { ARENA = 1 << 20 };
#include "arena.h"
#endif

static int refusals;

static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
  (void)environment, (void)name, (void)category, (void)message;
  refusals += status == fmi2Error;
}

static const fmi2CallbackFunctions callbacks = {hear, NULL, NULL, NULL, NULL};
enum { MANY = 100, U = 6, FIRST_OUTPUT = 10, REAL_OUTPUTS = 6, BEYOND = 17 };
static const double BASE = 0.00025;

/* Of this process alone: other work on the computer does not count. */
static double now_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* Best mean of 20 batches: a step of one base step with 100 values set and 100 read. */
static double idle_step_ns(fmi2Component c, long *step) {
  fmi2ValueReference in[MANY], out[MANY];
  double values[MANY], best = 1e300;
  for (unsigned k = 0; k < MANY; ++k) {
    in[k] = U + k % 4;
    out[k] = FIRST_OUTPUT + k % REAL_OUTPUTS;
    values[k] = 0.25;
  }
  for (int batch = 0; batch < 20; ++batch) {
    const double from = now_ns();
    for (int k = 0; k < 1000; ++k) {
      toy_fmi2SetReal(c, in, MANY, values);
      toy_fmi2DoStep(c, (double)*step * BASE, BASE, fmi2True);
      toy_fmi2GetReal(c, out, MANY, values);
      *step += 1;
      for (unsigned i = 0; i < MANY; ++i) {
        values[i] = 0.25;
      }
    }
    best = fmin(best, (now_ns() - from) / 1000);
  }
  return best;
}

/* All that can be done with a state, and what is refused */
static int states(fmi2Component c) {
  fmi2FMUstate state = NULL, copy = NULL;
  fmi2Byte bytes[4096];
  size_t size = 0;
  int bad = toy_fmi2GetFMUstate(c, &state) != fmi2OK;
  bad += toy_fmi2SerializedFMUstateSize(c, state, &size) != fmi2OK || size > sizeof bytes;
  bad += toy_fmi2SerializeFMUstate(c, state, bytes, size) != fmi2OK;
  for (size_t cut = 0; cut < size; ++cut) {
    bad += toy_fmi2DeSerializeFMUstate(c, bytes, cut, &copy) != fmi2Error;
  }
  bad += toy_fmi2DeSerializeFMUstate(c, bytes, size, &copy) != fmi2OK;
  bad += toy_fmi2SetFMUstate(c, copy) != fmi2OK;
  bad += toy_fmi2FreeFMUstate(c, &copy) != fmi2OK;
  bad += toy_fmi2FreeFMUstate(c, &state) != fmi2OK;
  return bad;
}

static int refused_values(fmi2Component c) {
  int bad = 0;
  const double wrong[] = {NAN, INFINITY, -INFINITY, 1e300};
  for (fmi2ValueReference vr = 0; vr < BEYOND + 3; ++vr) {
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
      bad += toy_fmi2SetReal(c, &vr, 1, wrong + k) != fmi2Error;
    }
  }
  double value = 0;
  const fmi2ValueReference beyond = BEYOND, largest = 0xffffffffu;
  bad += toy_fmi2GetReal(c, &beyond, 1, &value) != fmi2Error;
  bad += toy_fmi2GetReal(c, &largest, 1, &value) != fmi2Error;
  return bad;
}

int main(int count, char **arguments) {
  if (count != 3) {
    return 2;
  }
  fmi2Component one = toy_fmi2Instantiate("one", fmi2CoSimulation, arguments[1], NULL, &callbacks,
                                          fmi2False, fmi2False);
  const long at_instantiate = allocations;
  fmi2Component two = toy_two_fmi2Instantiate("two", fmi2CoSimulation, arguments[2], NULL,
                                              &callbacks, fmi2False, fmi2False);
  if (!one || !two) {
    return 3;
  }
  const long before = allocations;
  long step = 0;
  toy_fmi2EnterInitializationMode(one);
  toy_two_fmi2EnterInitializationMode(two);
  int bad = toy_fmi2ExitInitializationMode(one) != fmi2OK;
  bad += toy_two_fmi2ExitInitializationMode(two) != fmi2OK;
  const double ns = idle_step_ns(one, &step);
  bad += refused_values(one);
  bad += toy_two_fmi2DoStep(two, 0.0, 100 * BASE, fmi2True) != fmi2OK;
  const long in_steps = allocations - before;
  bad += states(one);
  bad += toy_fmi2Reset(one) != fmi2OK;
  toy_fmi2FreeInstance(one);
  toy_two_fmi2FreeInstance(two);
  printf("bad %d\nrefusals %d\nat_instantiate %ld\nin_steps %ld\nidle_ns %.0f\n", bad, refusals,
         at_instantiate, in_steps, ns);
  return 0;
}
