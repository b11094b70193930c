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
    [FLEXHEX_SET_DEBUG_LOGGING] = {"fmi2SetDebugLogging", I | M | C | T},
    [FLEXHEX_SETUP_EXPERIMENT] = {"fmi2SetupExperiment", I},
    [FLEXHEX_ENTER_INITIALIZATION_MODE] = {"fmi2EnterInitializationMode", I},
    [FLEXHEX_EXIT_INITIALIZATION_MODE] = {"fmi2ExitInitializationMode", M},
    [FLEXHEX_TERMINATE] = {"fmi2Terminate", C},
    [FLEXHEX_RESET] = {"fmi2Reset", I | M | C | T},
    [FLEXHEX_GET_REAL] = {"fmi2GetReal", M | C | T},
    [FLEXHEX_GET_INTEGER] = {"fmi2GetInteger", M | C | T},
    [FLEXHEX_GET_BOOLEAN] = {"fmi2GetBoolean", M | C | T},
    [FLEXHEX_GET_STRING] = {"fmi2GetString", M | C | T},
    [FLEXHEX_SET_REAL] = {"fmi2SetReal", I | M | C},
    [FLEXHEX_SET_INTEGER] = {"fmi2SetInteger", I | M | C},
    [FLEXHEX_SET_BOOLEAN] = {"fmi2SetBoolean", I | M | C},
    [FLEXHEX_SET_STRING] = {"fmi2SetString", I | M | C},
    [FLEXHEX_GET_FMU_STATE] = {"fmi2GetFMUstate", I | M | C | T},
    [FLEXHEX_SET_FMU_STATE] = {"fmi2SetFMUstate", I | M | C | T},
    [FLEXHEX_FREE_FMU_STATE] = {"fmi2FreeFMUstate", I | M | C | T},
    [FLEXHEX_SERIALIZED_FMU_STATE_SIZE] = {"fmi2SerializedFMUstateSize", I | M | C | T},
    [FLEXHEX_SERIALIZE_FMU_STATE] = {"fmi2SerializeFMUstate", I | M | C | T},
    [FLEXHEX_DESERIALIZE_FMU_STATE] = {"fmi2DeSerializeFMUstate", I | M | C | T},
    [FLEXHEX_GET_DIRECTIONAL_DERIVATIVE] = {"fmi2GetDirectionalDerivative", M | C | T},
    [FLEXHEX_SET_REAL_INPUT_DERIVATIVES] = {"fmi2SetRealInputDerivatives", I | M | C},
    [FLEXHEX_GET_REAL_OUTPUT_DERIVATIVES] = {"fmi2GetRealOutputDerivatives", C | T},
    [FLEXHEX_DO_STEP] = {"fmi2DoStep", C},
    [FLEXHEX_CANCEL_STEP] = {"fmi2CancelStep", 0},
    [FLEXHEX_GET_STATUS] = {"fmi2GetStatus", C | T},
    [FLEXHEX_GET_REAL_STATUS] = {"fmi2GetRealStatus", C | T},
    [FLEXHEX_GET_INTEGER_STATUS] = {"fmi2GetIntegerStatus", C | T},
    [FLEXHEX_GET_BOOLEAN_STATUS] = {"fmi2GetBooleanStatus", C | T},
    [FLEXHEX_GET_STRING_STATUS] = {"fmi2GetStringStatus", C | T},
    [FLEXHEX_FREE_INSTANCE] = {"fmi2FreeInstance", I | M | C | T},
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
  flexhex_instance *m = c;
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
