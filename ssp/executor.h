/* Runs a system of FMI 2.0 co-simulation FMUs, each at its own period.

   The schedule is data. Time is an integer count n of base steps. At every n the components
   whose period divides n first publish their outputs on the signal bus, then take their
   inputs from it and step from n to n + period. For FMUs that sample their inputs at their
   own ticks and show results one period later this gives, bit for bit, what stepping all of
   them at every base step gives.

   Everything is allocated by executor_open. A component without library and functions is
   the host's: the host writes its slots of the bus and reads what it needs.
   The strings and arrays of the descriptions belong to the caller and outlive the executor. */
#ifndef FLEXHEX_EXECUTOR_H
#define FLEXHEX_EXECUTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fmi2FunctionTypes.h"

typedef struct {
  fmi2InstantiateTYPE *instantiate;
  fmi2FreeInstanceTYPE *free_instance;
  fmi2SetDebugLoggingTYPE *set_debug_logging;
  fmi2SetupExperimentTYPE *setup_experiment;
  fmi2EnterInitializationModeTYPE *enter_initialization;
  fmi2ExitInitializationModeTYPE *exit_initialization;
  fmi2TerminateTYPE *terminate;
  fmi2GetRealTYPE *get_real;
  fmi2SetRealTYPE *set_real;
  fmi2GetIntegerTYPE *get_integer;
  fmi2SetIntegerTYPE *set_integer;
  fmi2GetBooleanTYPE *get_boolean;
  fmi2SetBooleanTYPE *set_boolean;
  fmi2DoStepTYPE *do_step;
} executor_functions;

/* Variables of one FMU, sorted by type. The bus holds all of them as double; an enumeration is an
   Integer, and a Boolean is 0 or 1. */
typedef struct {
  size_t n_reals, n_integers, n_booleans;
  const fmi2ValueReference *references; /* of the Reals, then the Integers, then the Booleans */
} executor_variables;

typedef struct {
  const char *name;
  const char *library;                 /* path of the shared library, or NULL */
  const executor_functions *functions; /* of an FMU that is linked in, or NULL */
  const char *guid;
  const char *resources; /* URI of the FMU's resources folder */
  int64_t period;        /* base steps between two steps */
  executor_variables parameters;
  const double *values; /* of the parameters */
  executor_variables inputs;
  const size_t *sources; /* bus slot of every input */
  executor_variables outputs;
  size_t slot; /* bus slot of the first output; the others follow */
  size_t n_categories;
  const char *const *categories; /* log categories to switch on; none: FMU's choice */
} executor_component;

/* Signals sampled at n = 0, period, 2 period, ...: row after row into the caller's buffer. */
typedef struct {
  int64_t period;
  size_t n_slots;
  const size_t *slots;
  double *rows;
  size_t capacity; /* in rows */
  size_t count;    /* rows written so far */
} executor_log;

typedef struct {
  double seconds; /* spent in calls of this FMU while stepping */
  double worst;   /* longest single step [s] */
  uint64_t steps;
  uint64_t warnings; /* messages of status fmi2Warning */
} executor_times;

typedef struct executor executor;

/* Load, instantiate, set parameters, initialise. base: base step [s]. Returns NULL with one
   line in message when anything fails; nothing is left behind then. */
executor *executor_open(const executor_component *components, size_t n_components, size_t n_slots,
                        double base, executor_log *logs, size_t n_logs, bool timing, char *message,
                        size_t size);

/* Run from the current n to n = until, which is published and logged too. May be called
   again. Returns false when an FMU failed: executor_message names the FMU, the call and the time.
 */
bool executor_run(executor *e, int64_t until);

/* Rows of n_slots values that the executor writes to the bus itself, from `slot` on: row n at n,
   the last one from then on. They are the caller's and outlive the executor. Before executor_run.
 */
void executor_play(executor *e, const double *rows, size_t n_rows, size_t slot, size_t n_slots);

int64_t executor_now(const executor *e);
const char *executor_message(const executor *e);
double *executor_bus(executor *e);
executor_times executor_time_of(const executor *e, size_t component);

/* The FMU's instance, for functions of FMI that the executor does not call, such as those of its
   state; NULL for the host's own component. */
fmi2Component executor_instance(const executor *e, size_t component);

/* First warning that the FMU logged, such as a fault; empty when there is none. */
const char *executor_warning_of(const executor *e, size_t component);

/* Terminate and free all instances and libraries; e may be NULL. */
void executor_close(executor *e);

/* The parts of executor_run, for a host that keeps its own time: outputs to the bus; inputs
   from the bus at n; one step from n to n + period. */
bool executor_publish(executor *e, size_t component, int64_t n);
bool executor_feed(executor *e, size_t component, int64_t n);
bool executor_advance(executor *e, size_t component, int64_t n);

#endif
