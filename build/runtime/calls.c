/* Which function may be called in which state: FMI 2.0.4, section 4.2.4.

   The standard's states stepInProgress, stepFailed and stepCanceled do not occur: a step is
   complete when fmi2DoStep returns, and one that is discarded was not begun. Nor does error: a
   refused call leaves the instance as it was, and the output fault shows it. */
#include "instance.h"

enum {
  I = FLEXHEX_INSTANTIATED,
  M = FLEXHEX_INITIALIZATION_MODE,
  C = FLEXHEX_STEP_COMPLETE,
  T = FLEXHEX_TERMINATED
};

static const struct {
  const char *name;
  int phases;
} calls[FLEXHEX_N_CALLS] = {
#define ROW(call, name, phases) {name, phases},
    FLEXHEX_CALLS(ROW)
#undef ROW
};

const char *flexhex_call_name(flexhex_call call) {
  return calls[call].name;
}

static const char *phase_name(int32_t phase) {
  switch (phase) {
    case FLEXHEX_INSTANTIATED:
      return "Instantiated";
    case FLEXHEX_INITIALIZATION_MODE:
      return "InitializationMode";
    case FLEXHEX_STEP_COMPLETE:
      return "StepComplete";
    default:
      return "Terminated";
  }
}

flexhex_instance *flexhex_enter(fmi2Component c, flexhex_call call) {
  flexhex_instance *m = (flexhex_instance *)c;
  /* the magic word finds a wrong or freed pointer as long as its memory is still there */
  if (!m || m->magic != FLEXHEX_MAGIC) {
    return NULL;
  }
  if (!(m->head->phase & calls[call].phases)) {
    (void)flexhex_refuse(m, "%s is not allowed in state %s", calls[call].name,
                         phase_name(m->head->phase));
    return NULL;
  }
  return m;
}
