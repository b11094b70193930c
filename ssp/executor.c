/* Long: whoever links the executor, the gateway or a test, compiles just this one file. */
#define _POSIX_C_SOURCE 200809L

#include "executor.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MESSAGE = 768, LOGGED = 400 };

typedef struct {
  const executor_component *description;
  executor_functions call;
  void *library;
  fmi2Component instance;
  bool initialised;
  fmi2Status status; /* of the last call */
  double *inputs;
  executor_times times;
  char logged[LOGGED]; /* last error message of the FMU */
  char warned[LOGGED]; /* first warning */
} unit;

struct executor {
  unit *units;
  size_t n_units;
  double *bus;
  double base;
  executor_log *logs;
  size_t n_logs;
  int64_t now;
  bool published; /* what belongs to `now` is on the bus and in the logs */
  bool timing;
  bool failed;
  char message[MESSAGE];
  fmi2CallbackFunctions callbacks[]; /* one for each unit: they carry its address */
};

/* The FMU's logger: keeps its last error for the error text, and its first warning. */
static void keep_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                         fmi2String category, fmi2String message, ...) {
  unit *u = environment;
  va_list arguments;
  (void)name;
  (void)category;
  if (u == NULL || status == fmi2OK || message == NULL) {
    return;
  }
  if (status == fmi2Warning && u->times.warnings++ > 0) {
    return;
  }
  va_start(arguments, message);
  (void)vsnprintf(status == fmi2Warning ? u->warned : u->logged, LOGGED, message, arguments);
  va_end(arguments);
}

static bool fail(executor *e, const unit *u, const char *what, double t) {
  static const char *const names[] = {"fmi2OK",    "fmi2Warning", "fmi2Discard",
                                      "fmi2Error", "fmi2Fatal",   "fmi2Pending"};
  const char *status = (unsigned)u->status < 6U ? names[u->status] : "an unknown status";
  const char *logged = u->logged[0] != '\0' ? u->logged : "the FMU gave no message";
  (void)snprintf(e->message, sizeof e->message, "%s: %s at t = %.9g s returned %s: %s",
                 u->description->name, what, t, status, logged);
  e->failed = true;
  return false;
}

static bool accept(executor *e, unit *u, fmi2Status status, const char *what, double t) {
  u->status = status;
  return status == fmi2OK || status == fmi2Warning || fail(e, u, what, t);
}

static bool find(executor *e, unit *u, const char *name, void *target) {
  void *symbol = dlsym(u->library, name);
  if (symbol == NULL) {
    (void)snprintf(e->message, sizeof e->message, "%s: %s lacks the function %s",
                   u->description->name, u->description->library, name);
    return false;
  }
  memcpy(target, &symbol, sizeof symbol);
  return true;
}

static bool load(executor *e, unit *u) {
  const executor_component *d = u->description;
  if (d->functions != NULL) {
    u->call = *d->functions;
    return true;
  }
  u->library = dlopen(d->library, RTLD_NOW | RTLD_LOCAL);
  if (u->library == NULL) {
    const char *reason = dlerror();
    (void)snprintf(e->message, sizeof e->message, "%s: its library does not load: %s", d->name,
                   reason != NULL ? reason : "no reason given");
    return false;
  }
  return find(e, u, "fmi2Instantiate", &u->call.instantiate) &&
         find(e, u, "fmi2FreeInstance", &u->call.free_instance) &&
         find(e, u, "fmi2SetDebugLogging", &u->call.set_debug_logging) &&
         find(e, u, "fmi2SetupExperiment", &u->call.setup_experiment) &&
         find(e, u, "fmi2EnterInitializationMode", &u->call.enter_initialization) &&
         find(e, u, "fmi2ExitInitializationMode", &u->call.exit_initialization) &&
         find(e, u, "fmi2Terminate", &u->call.terminate) &&
         find(e, u, "fmi2GetReal", &u->call.get_real) &&
         find(e, u, "fmi2SetReal", &u->call.set_real) && find(e, u, "fmi2DoStep", &u->call.do_step);
}

static bool is_host(const executor_component *d) {
  return d->library == NULL && d->functions == NULL;
}

static bool initialise(executor *e, unit *u, const fmi2CallbackFunctions *callbacks) {
  const executor_component *d = u->description;
  const executor_functions *call = &u->call;
  fmi2Component c = call->instantiate(d->name, fmi2CoSimulation, d->guid, d->resources, callbacks,
                                      fmi2False, fmi2True);
  u->instance = c;
  if (c == NULL) {
    u->status = fmi2Error;
    return fail(e, u, "fmi2Instantiate", 0.0);
  }
  if (d->n_categories > 0 &&
      !accept(e, u, call->set_debug_logging(c, fmi2True, d->n_categories, d->categories),
              "fmi2SetDebugLogging", 0.0)) {
    return false;
  }
  if (!accept(e, u, call->setup_experiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0),
              "fmi2SetupExperiment", 0.0)) {
    return false;
  }
  if (d->n_parameters > 0 &&
      !accept(e, u, call->set_real(c, d->parameters, d->n_parameters, d->values),
              "fmi2SetReal of parameters", 0.0)) {
    return false;
  }
  if (!accept(e, u, call->enter_initialization(c), "fmi2EnterInitializationMode", 0.0) ||
      !accept(e, u, call->exit_initialization(c), "fmi2ExitInitializationMode", 0.0)) {
    return false;
  }
  u->initialised = true;
  return true;
}

static bool open_unit(executor *e, size_t k, const executor_component *d) {
  unit *u = &e->units[k];
  fmi2CallbackFunctions callbacks = {keep_message, calloc, free, NULL, u};
  u->description = d;
  if (is_host(d)) {
    return true;
  }
  u->inputs = calloc(d->n_inputs > 0 ? d->n_inputs : 1, sizeof *u->inputs);
  if (u->inputs == NULL) {
    (void)snprintf(e->message, sizeof e->message, "%s: out of memory", d->name);
    return false;
  }
  memcpy(&e->callbacks[k], &callbacks, sizeof callbacks);
  return load(e, u) && initialise(e, u, &e->callbacks[k]);
}

static executor *allocate(size_t n_components, size_t n_slots) {
  executor *e = calloc(1, sizeof *e + n_components * sizeof e->callbacks[0]);
  if (e == NULL) {
    return NULL;
  }
  e->units = calloc(n_components > 0 ? n_components : 1, sizeof *e->units);
  e->bus = calloc(n_slots > 0 ? n_slots : 1, sizeof *e->bus);
  if (e->units == NULL || e->bus == NULL) {
    executor_close(e);
    return NULL;
  }
  return e;
}

executor *executor_open(const executor_component *components, size_t n_components, size_t n_slots,
                        double base, executor_log *logs, size_t n_logs, bool timing, char *message,
                        size_t size) {
  executor *e = allocate(n_components, n_slots);
  size_t k;
  if (e == NULL) {
    (void)snprintf(message, size, "out of memory");
    return NULL;
  }
  e->base = base;
  e->logs = logs;
  e->n_logs = n_logs;
  e->timing = timing;
  for (k = 0; k < n_components; k++) {
    e->n_units = k + 1;
    if (!open_unit(e, k, &components[k])) {
      (void)snprintf(message, size, "%s", e->message);
      executor_close(e);
      return NULL;
    }
  }
  return e;
}

static void close_unit(unit *u) {
  if (u->instance != NULL && u->status != fmi2Fatal) {
    if (u->initialised && (u->status == fmi2OK || u->status == fmi2Warning)) {
      (void)u->call.terminate(u->instance);
    }
    u->call.free_instance(u->instance);
  }
  if (u->library != NULL) {
    (void)dlclose(u->library);
  }
  free(u->inputs);
}

void executor_close(executor *e) {
  size_t k;
  if (e == NULL) {
    return;
  }
  for (k = 0; k < e->n_units; k++) {
    close_unit(&e->units[k]);
  }
  free(e->units);
  free(e->bus);
  free(e);
}

static double clock_now(const executor *e) {
  struct timespec t = {0, 0};
  if (e->timing) {
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
  }
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool executor_publish(executor *e, size_t component, int64_t n) {
  unit *u = &e->units[component];
  const executor_component *d = u->description;
  if (u->instance == NULL || d->n_outputs == 0) {
    return true;
  }
  return accept(e, u, u->call.get_real(u->instance, d->outputs, d->n_outputs, &e->bus[d->slot]),
                "fmi2GetReal", (double)n * e->base);
}

bool executor_feed(executor *e, size_t component, int64_t n) {
  unit *u = &e->units[component];
  const executor_component *d = u->description;
  size_t i;
  if (u->instance == NULL || d->n_inputs == 0) {
    return true;
  }
  for (i = 0; i < d->n_inputs; i++) {
    u->inputs[i] = e->bus[d->sources[i]];
  }
  return accept(e, u, u->call.set_real(u->instance, d->inputs, d->n_inputs, u->inputs),
                "fmi2SetReal of inputs", (double)n * e->base);
}

bool executor_advance(executor *e, size_t component, int64_t n) {
  unit *u = &e->units[component];
  double t = (double)n * e->base;
  double h = (double)u->description->period * e->base;
  if (u->instance == NULL) {
    return true;
  }
  u->times.steps++;
  return accept(e, u, u->call.do_step(u->instance, t, h, fmi2True), "fmi2DoStep", t);
}

static bool append_rows(executor *e) {
  size_t k;
  for (k = 0; k < e->n_logs; k++) {
    executor_log *log = &e->logs[k];
    size_t i;
    if (e->now % log->period != 0) {
      continue;
    }
    if (log->count == log->capacity) {
      (void)snprintf(e->message, sizeof e->message, "log %zu is full after %zu rows", k,
                     log->count);
      e->failed = true;
      return false;
    }
    for (i = 0; i < log->n_slots; i++) {
      log->rows[log->count * log->n_slots + i] = e->bus[log->slots[i]];
    }
    log->count++;
  }
  return true;
}

static bool publish_due(executor *e) {
  size_t k;
  for (k = 0; k < e->n_units; k++) {
    unit *u = &e->units[k];
    if (e->now % u->description->period == 0) {
      double begin = clock_now(e);
      if (!executor_publish(e, k, e->now)) {
        return false;
      }
      u->times.seconds += clock_now(e) - begin;
    }
  }
  return append_rows(e);
}

static bool step_due(executor *e) {
  size_t k;
  for (k = 0; k < e->n_units; k++) {
    unit *u = &e->units[k];
    if (e->now % u->description->period == 0) {
      double begin = clock_now(e);
      double spent;
      if (!executor_feed(e, k, e->now) || !executor_advance(e, k, e->now)) {
        return false;
      }
      spent = clock_now(e) - begin;
      u->times.seconds += spent;
      u->times.worst = spent > u->times.worst ? spent : u->times.worst;
    }
  }
  return true;
}

bool executor_run(executor *e, int64_t until) {
  while (!e->failed) {
    if (!e->published) {
      if (!publish_due(e)) {
        return false;
      }
      e->published = true;
    }
    if (e->now >= until) {
      return true;
    }
    if (!step_due(e)) {
      return false;
    }
    e->now++;
    e->published = false;
  }
  return false;
}

int64_t executor_now(const executor *e) {
  return e->now;
}

const char *executor_message(const executor *e) {
  return e->message;
}

double *executor_bus(executor *e) {
  return e->bus;
}

const char *executor_warning_of(const executor *e, size_t component) {
  return e->units[component].warned;
}

executor_times executor_time_of(const executor *e, size_t component) {
  return e->units[component].times;
}
