/* An FMU's binary that stands before the real one and spoils it, for tests of faults.

   The real binary is resources/real.so. resources/proxy.txt says what to do, in one line:

     INSTANCE STEP COUNT KIND REFERENCE VALUE

   From the step STEP (0 is the first; step k goes from k to k + 1 sample times) for COUNT steps,
   in the instance of that name (the other instances of the FMU are left alone):
     set    outputs of value reference REFERENCE are VALUE (`nan`, `inf`, a number)
     error  fmi2DoStep returns fmi2Error
     sleep  fmi2DoStep takes VALUE seconds more
     hang   fmi2DoStep says so and never returns; step -1: fmi2ExitInitializationMode
     crash  fmi2DoStep ends the process (SIGABRT)
     instantiate, get, put, terminate, free
            this call says so and never returns: fmi2Instantiate, a getter or setter of outputs and
            inputs after STEP steps, fmi2Terminate, fmi2FreeInstance
   Only the functions that the executor calls are there. */
#define _POSIX_C_SOURCE 200809L

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "fmi2Functions.h"

typedef struct {
  long first, count, step; /* step: calls of fmi2DoStep so far */
  char kind[16];
  fmi2ValueReference reference;
  double value;
  fmi2Component real;
  void *library;
} proxy;

/* The real function `name`, as a pointer of type `name##TYPE`. */
#define REAL(p, name)                        \
  name##TYPE *real;                          \
  void *symbol = dlsym((p)->library, #name); \
  memcpy(&real, &symbol, sizeof real)

static int spoils(const proxy *p, const char *kind, long step) {
  return strcmp(p->kind, kind) == 0 && step >= p->first && step - p->first < p->count;
}

static void hang_at(const proxy *p, const char *kind, long step) {
  if (spoils(p, kind, step)) {
    (void)fputs("hangs\n", stderr);
    for (;;) {
      (void)pause();
    }
  }
}

/* Reads proxy.txt; a proxy that cannot, or is of another instance, spoils nothing. */
static void configure(proxy *p, const char *folder, const char *name) {
  char path[4096], instance[256];
  FILE *file;
  (void)snprintf(path, sizeof path, "%s/proxy.txt", folder);
  file = fopen(path, "r");
  if (file == NULL ||
      fscanf(file, "%255s %ld %ld %15s %u %lf", instance, &p->first, &p->count, p->kind,
             &p->reference, &p->value) != 6 ||
      strcmp(instance, name) != 0) {
    p->count = 0;
  }
  if (file != NULL) {
    (void)fclose(file);
  }
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                          fmi2String resources,
                                          const fmi2CallbackFunctions *callbacks,
                                          fmi2Boolean visible, fmi2Boolean logging) {
  const char *folder = strncmp(resources, "file://", 7) == 0 ? resources + 7 : resources;
  char path[4096];
  proxy *p = calloc(1, sizeof *p);
  if (p == NULL) {
    return NULL;
  }
  configure(p, folder, name);
  (void)snprintf(path, sizeof path, "%s/real.so", folder);
  p->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (p->library != NULL) {
    REAL(p, fmi2Instantiate);
    p->real = real(name, type, guid, resources, callbacks, visible, logging);
  }
  if (p->real == NULL) {
    free(p);
    return NULL;
  }
  hang_at(p, "instantiate", p->first);
  return p;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c) {
  proxy *p = c;
  REAL(p, fmi2FreeInstance);
  hang_at(p, "free", p->first);
  real(p->real);
  (void)dlclose(p->library);
  free(p);
}

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                                           const fmi2String categories[]) {
  proxy *p = c;
  REAL(p, fmi2SetDebugLogging);
  return real(p->real, on, n, categories);
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerant,
                                           fmi2Real tolerance, fmi2Real start, fmi2Boolean stops,
                                           fmi2Real stop) {
  proxy *p = c;
  REAL(p, fmi2SetupExperiment);
  return real(p->real, tolerant, tolerance, start, stops, stop);
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  proxy *p = c;
  REAL(p, fmi2EnterInitializationMode);
  return real(p->real);
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  proxy *p = c;
  REAL(p, fmi2ExitInitializationMode);
  hang_at(p, "hang", -1);
  return real(p->real);
}

FMI2_Export fmi2Status fmi2Terminate(fmi2Component c) {
  proxy *p = c;
  REAL(p, fmi2Terminate);
  hang_at(p, "terminate", p->first);
  return real(p->real);
}

#define PASS(type, name)                                                                       \
  FMI2_Export fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference references[], \
                                       size_t n, type values[]) {                              \
    proxy *p = c;                                                                              \
    fmi2Status status;                                                                         \
    size_t k;                                                                                  \
    REAL(p, fmi2Get##name);                                                                    \
    hang_at(p, "get", p->step);                                                                \
    status = real(p->real, references, n, values);                                             \
    for (k = 0; k < n && spoils(p, "set", p->step - 1); k++) {                                 \
      values[k] = references[k] == p->reference ? (type)p->value : values[k];                  \
    }                                                                                          \
    return status;                                                                             \
  }                                                                                            \
  FMI2_Export fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference references[], \
                                       size_t n, const type values[]) {                        \
    proxy *p = c;                                                                              \
    REAL(p, fmi2Set##name);                                                                    \
    hang_at(p, "put", p->step);                                                                \
    return real(p->real, references, n, values);                                               \
  }
PASS(fmi2Real, Real)
PASS(fmi2Integer, Integer)
PASS(fmi2Boolean, Boolean)

FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size,
                                  fmi2Boolean final) {
  proxy *p = c;
  const long step = p->step++;
  REAL(p, fmi2DoStep);
  if (spoils(p, "sleep", step)) {
    const struct timespec longer = {(time_t)p->value,
                                    (long)(1e9 * (p->value - (double)(time_t)p->value))};
    (void)nanosleep(&longer, NULL);
  }
  hang_at(p, "hang", step);
  if (spoils(p, "crash", step)) {
    abort();
  }
  return spoils(p, "error", step) ? fmi2Error : real(p->real, time, size, final);
}
