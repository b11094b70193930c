/* One FMU instance, and what the adapter's files offer each other. */
#ifndef FLEXHEX_INSTANCE_H
#define FLEXHEX_INSTANCE_H

#include <stdint.h>

#include "fmi.h"

#if defined __GNUC__
#define FLEXHEX_PRINTF(text, values) __attribute__((format(printf, text, values)))
#else
#define FLEXHEX_PRINTF(text, values)
#endif

/* internal names wear the FMU's identifier too, so that all FMUs link into one program */
#define FLEXHEX_OWN(name) FLEXHEX_JOIN(FLEXHEX_IDENTIFIER, name)
#define flexhex_enter FLEXHEX_OWN(_flexhex_enter)
#define flexhex_call_name FLEXHEX_OWN(_flexhex_call_name)
#define flexhex_number FLEXHEX_OWN(_flexhex_number)
#define flexhex_say FLEXHEX_OWN(_flexhex_say)
#define flexhex_log FLEXHEX_OWN(_flexhex_log)
#define flexhex_refuse FLEXHEX_OWN(_flexhex_refuse)
#define flexhex_start FLEXHEX_OWN(_flexhex_start)
#define flexhex_publish FLEXHEX_OWN(_flexhex_publish)
#define flexhex_categories FLEXHEX_OWN(_flexhex_categories)

#define FLEXHEX_MAGIC UINT64_C(0x666c657868657831) /* "flexhex1": this is an instance */

typedef enum {
  FLEXHEX_INSTANTIATED = 1,
  FLEXHEX_INITIALIZATION_MODE = 2,
  FLEXHEX_STEP_COMPLETE = 4,
  FLEXHEX_TERMINATED = 8
} flexhex_phase;

typedef enum {
  FLEXHEX_ERRORS,
  FLEXHEX_WARNINGS,
  FLEXHEX_EVENTS,
  FLEXHEX_N_CATEGORIES
} flexhex_category;
enum { FLEXHEX_ALL_CATEGORIES = (1 << FLEXHEX_N_CATEGORIES) - 1 };
extern const char *const flexhex_categories[FLEXHEX_N_CATEGORIES];

/* Everything about an instance that changes and that an FMU state must bring back. It is the head
   of one contiguous block: head, values by value reference, pending outputs, state of step.c. */
typedef struct {
  int64_t step;   /* base steps done */
  int64_t period; /* base steps per Ts */
  double start_time, stop_time;
  int32_t phase;
  int32_t refused; /* 1: a call was refused since the last reset: fault is 1 at least */
} flexhex_head;

typedef struct {
  fmi2CallbackFunctions functions;
  uint64_t magic;
  int logging, first_logging; /* a bit for each category: now, and as instantiated */
  size_t block_size;
  flexhex_head *head; /* start of the block; the next three point into it */
  double *values, *pending;
  void *state;
  const double *inputs;
  double *outputs;
  unsigned n_values, n_outputs, first_output;
  int *owner; /* value reference -> index into the table of variables */
  int *first; /* variable -> its first value reference */
  char *name;
} flexhex_instance;

/* calls.c */
/* Every function of FMI: its name here, its name, the phases in which it may be called */
#define FLEXHEX_CALLS(X)                                                    \
  X(SET_DEBUG_LOGGING, "fmi2SetDebugLogging", I | M | C | T)                \
  X(SETUP_EXPERIMENT, "fmi2SetupExperiment", I)                             \
  X(ENTER_INITIALIZATION_MODE, "fmi2EnterInitializationMode", I)            \
  X(EXIT_INITIALIZATION_MODE, "fmi2ExitInitializationMode", M)              \
  X(TERMINATE, "fmi2Terminate", C)                                          \
  X(RESET, "fmi2Reset", I | M | C | T)                                      \
  X(GET_REAL, "fmi2GetReal", M | C | T)                                     \
  X(GET_INTEGER, "fmi2GetInteger", M | C | T)                               \
  X(GET_BOOLEAN, "fmi2GetBoolean", M | C | T)                               \
  X(GET_STRING, "fmi2GetString", M | C | T)                                 \
  X(SET_REAL, "fmi2SetReal", I | M | C)                                     \
  X(SET_INTEGER, "fmi2SetInteger", I | M | C)                               \
  X(SET_BOOLEAN, "fmi2SetBoolean", I | M | C)                               \
  X(SET_STRING, "fmi2SetString", I | M | C)                                 \
  X(GET_FMU_STATE, "fmi2GetFMUstate", I | M | C | T)                        \
  X(SET_FMU_STATE, "fmi2SetFMUstate", I | M | C | T)                        \
  X(FREE_FMU_STATE, "fmi2FreeFMUstate", I | M | C | T)                      \
  X(SERIALIZED_FMU_STATE_SIZE, "fmi2SerializedFMUstateSize", I | M | C | T) \
  X(SERIALIZE_FMU_STATE, "fmi2SerializeFMUstate", I | M | C | T)            \
  X(DESERIALIZE_FMU_STATE, "fmi2DeSerializeFMUstate", I | M | C | T)        \
  X(GET_DIRECTIONAL_DERIVATIVE, "fmi2GetDirectionalDerivative", M | C | T)  \
  X(SET_REAL_INPUT_DERIVATIVES, "fmi2SetRealInputDerivatives", I | M | C)   \
  X(GET_REAL_OUTPUT_DERIVATIVES, "fmi2GetRealOutputDerivatives", C | T)     \
  X(DO_STEP, "fmi2DoStep", C)                                               \
  X(CANCEL_STEP, "fmi2CancelStep", 0)                                       \
  X(GET_STATUS, "fmi2GetStatus", C | T)                                     \
  X(GET_REAL_STATUS, "fmi2GetRealStatus", C | T)                            \
  X(GET_INTEGER_STATUS, "fmi2GetIntegerStatus", C | T)                      \
  X(GET_BOOLEAN_STATUS, "fmi2GetBooleanStatus", C | T)                      \
  X(GET_STRING_STATUS, "fmi2GetStringStatus", C | T)                        \
  X(FREE_INSTANCE, "fmi2FreeInstance", I | M | C | T)
typedef enum {
#define FLEXHEX_MEMBER(call, name, phases) FLEXHEX_##call,
  FLEXHEX_CALLS(FLEXHEX_MEMBER)
#undef FLEXHEX_MEMBER
      FLEXHEX_N_CALLS
} flexhex_call;

/* The instance behind c when `call` is allowed now; NULL, with a message, when it is not. */
flexhex_instance *flexhex_enter(fmi2Component c, flexhex_call call);
const char *flexhex_call_name(flexhex_call call);

/* messages.c */
enum { FLEXHEX_NUMBER_SIZE = 32 };
/* Shortest text that reads back as value; text[FLEXHEX_NUMBER_SIZE] is where it may be built. */
const char *flexhex_number(char *text, double value);
/* To the importer, whatever is switched on; functions->logger may be NULL. */
void flexhex_say(const fmi2CallbackFunctions *functions, const char *instance, fmi2Status status,
                 const char *category, const char *text);
/* To the importer when the category is switched on. */
void flexhex_log(const flexhex_instance *m, fmi2Status status, flexhex_category category,
                 const char *format, ...) FLEXHEX_PRINTF(4, 5);
/* Say what is wrong, raise the output fault, return fmi2Error; nothing else changes. */
fmi2Status flexhex_refuse(flexhex_instance *m, const char *format, ...) FLEXHEX_PRINTF(2, 3);

/* advance.c */
/* State and initial outputs from the parameters; false, refused, when those are wrong. */
bool flexhex_start(flexhex_instance *m);
void flexhex_publish(flexhex_instance *m);

#endif
