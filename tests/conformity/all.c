/* All FMUs linked into one program, stepped in turn; counts what is allocated meanwhile.

   Built from every FMU's sources with -DFLEXHEX_STATIC, or from one FMU's with '-DFMUS(X)=X(name)';
   prints `name hash` of all outputs of the course for each FMU, then `allocated` and `bad`. */
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmi2FunctionTypes.h"
#include "model.h"

enum { STEPS = 1000, MOST = 2048, ARENA = 1 << 24 };
#include "arena.h"

#ifndef FMUS
#define FMUS(X) \
  X(reference)  \
  X(pose)       \
  X(kinematics) \
  X(feedforward) X(feedback) X(plant) X(filter) X(estimator) X(machine)
#endif

#define DECLARE(id)                                                        \
  extern const flexhex_model id##_fmu;                                     \
  extern fmi2InstantiateTYPE id##_fmi2Instantiate;                         \
  extern fmi2FreeInstanceTYPE id##_fmi2FreeInstance;                       \
  extern fmi2EnterInitializationModeTYPE id##_fmi2EnterInitializationMode; \
  extern fmi2ExitInitializationModeTYPE id##_fmi2ExitInitializationMode;   \
  extern fmi2GetRealTYPE id##_fmi2GetReal;                                 \
  extern fmi2SetRealTYPE id##_fmi2SetReal;                                 \
  extern fmi2DoStepTYPE id##_fmi2DoStep;
FMUS(DECLARE)

typedef struct {
  const char *name;
  const flexhex_model *model;
  fmi2InstantiateTYPE *instantiate;
  fmi2FreeInstanceTYPE *free_instance;
  fmi2EnterInitializationModeTYPE *enter;
  fmi2ExitInitializationModeTYPE *leave;
  fmi2GetRealTYPE *get;
  fmi2SetRealTYPE *set;
  fmi2DoStepTYPE *step;
  fmi2Component c;
  uint64_t hash;
} fmu;

#define ENTRY(id)                    \
  {#id,                              \
   &id##_fmu,                        \
   id##_fmi2Instantiate,             \
   id##_fmi2FreeInstance,            \
   id##_fmi2EnterInitializationMode, \
   id##_fmi2ExitInitializationMode,  \
   id##_fmi2GetReal,                 \
   id##_fmi2SetReal,                 \
   id##_fmi2DoStep,                  \
   NULL,                             \
   UINT64_C(0xcbf29ce484222325)},
static fmu fmus[] = {FMUS(ENTRY)};
enum { COUNT = sizeof fmus / sizeof *fmus };

static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
  (void)environment, (void)status, (void)category;
  fprintf(stderr, "%s: %s\n", name, message);
}

static const fmi2CallbackFunctions callbacks = {hear, NULL, NULL, NULL, NULL};

/* Inputs a little beside their start values, outputs into the hash (FNV-1a) */
static int one_step(fmu *f, int n) {
  static fmi2ValueReference in[MOST], out[MOST];
  static double u[MOST], y[MOST];
  size_t n_in = 0, n_out = 0;
  unsigned vr = 0;
  for (int k = 0; k < f->model->n_variables; ++k) {
    const flexhex_variable *v = &f->model->variables[k];
    for (int i = 0; i < (v->size ? v->size : 1); ++i, ++vr) {
      if (v->kind == FLEXHEX_INPUT) {
        const double wanted = f->model->starts[vr] + 1e-3 * ((n * 7 + (int)vr) % 11 - 5);
        in[n_in] = vr;
        u[n_in++] = fmin(fmax(wanted, v->min), v->max);
      } else if (v->kind == FLEXHEX_OUTPUT) {
        out[n_out++] = vr;
      }
    }
  }
  const double base = f->model->base_step;
  int bad = f->set(f->c, in, n_in, u) != fmi2OK;
  bad += f->step(f->c, n * base, base, fmi2True) != fmi2OK;
  bad += f->get(f->c, out, n_out, y) != fmi2OK;
  unsigned char bytes[sizeof y];
  memcpy(bytes, y, n_out * sizeof *y);
  for (size_t k = 0; k < n_out * sizeof *y; ++k) {
    f->hash = (f->hash ^ bytes[k]) * UINT64_C(0x100000001b3);
  }
  return bad;
}

int main(void) {
  int bad = 0;
  for (fmu *f = fmus; f < fmus + COUNT; ++f) {
    f->c = f->instantiate(f->name, fmi2CoSimulation, f->model->guid, NULL, &callbacks, fmi2False,
                          fmi2False);
    if (!f->c) {
      return 3;
    }
  }
  const long at_start = allocations;
  for (fmu *f = fmus; f < fmus + COUNT; ++f) {
    bad += f->enter(f->c) != fmi2OK || f->leave(f->c) != fmi2OK;
  }
  for (int n = 0; n < STEPS; ++n) {
    for (fmu *f = fmus; f < fmus + COUNT; ++f) {
      bad += one_step(f, n);
    }
  }
  const long in_steps = allocations - at_start;
  for (fmu *f = fmus; f < fmus + COUNT; ++f) {
    f->free_instance(f->c);
    printf("%s %" PRIx64 "\n", f->name, f->hash);
  }
  printf("allocated %lx\nbad %x\nat_start %lx\n", (unsigned long)in_steps, (unsigned)bad,
         (unsigned long)at_start);
  return 0;
}
