/* Long: one file, so that a program that links the executor compiles just this one. */
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
  int *whole; /* what passes as Integer or Boolean */
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
  const double *played; /* rows of n_played values for the bus, from played_slot on */
  size_t n_rows, n_played, played_slot;
  int64_t now;
  bool published; /* what belongs to `now` is on the bus and in the logs */
  bool timing;
  bool failed;
  char message[MESSAGE];
  fmi2CallbackFunctions callbacks[]; /* one for each unit: they carry its address */
};

/* The FMU's logger: stores its last error for the error message, and its first warning. */
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
         find(e, u, "fmi2SetReal", &u->call.set_real) &&
         find(e, u, "fmi2GetInteger", &u->call.get_integer) &&
         find(e, u, "fmi2SetInteger", &u->call.set_integer) &&
         find(e, u, "fmi2GetBoolean", &u->call.get_boolean) &&
         find(e, u, "fmi2SetBoolean", &u->call.set_boolean) &&
         find(e, u, "fmi2DoStep", &u->call.do_step);
}

static size_t count_of(const executor_variables *v) {
  return v->n_reals + v->n_integers + v->n_booleans;
}

/* Names of the calls that set, by type */
typedef struct {
  const char *real, *integer, *boolean;
} setters;
static const setters OF_PARAMETERS = {"fmi2SetReal of parameters", "fmi2SetInteger of parameters",
                                      "fmi2SetBoolean of parameters"};
static const setters OF_INPUTS = {"fmi2SetReal of inputs", "fmi2SetInteger of inputs",
                                  "fmi2SetBoolean of inputs"};

static bool set_values(executor *e, unit *u, const executor_variables *v, const double *values,
                       const setters *what, double t) {
  const fmi2ValueReference *integers = v->references + v->n_reals;
  const fmi2ValueReference *booleans = integers + v->n_integers;
  const size_t n = count_of(v);
  size_t i;
  if (n == 0) {
    return true;
  }
  for (i = v->n_reals; i < n; i++) {
    u->whole[i - v->n_reals] = (int)values[i];
  }
  if (v->n_reals > 0 &&
      !accept(e, u, u->call.set_real(u->instance, v->references, v->n_reals, values), what->real,
              t)) {
    return false;
  }
  if (v->n_integers > 0 &&
      !accept(e, u, u->call.set_integer(u->instance, integers, v->n_integers, u->whole),
              what->integer, t)) {
    return false;
  }
  return v->n_booleans == 0 ||
         accept(e, u,
                u->call.set_boolean(u->instance, booleans, v->n_booleans, u->whole + v->n_integers),
                what->boolean, t);
}

static bool get_values(executor *e, unit *u, const executor_variables *v, double *values,
                       double t) {
  const fmi2ValueReference *integers = v->references + v->n_reals;
  const fmi2ValueReference *booleans = integers + v->n_integers;
  int *flags = u->whole + v->n_integers;
  size_t i;
  if (v->n_reals > 0 &&
      !accept(e, u, u->call.get_real(u->instance, v->references, v->n_reals, values), "fmi2GetReal",
              t)) {
    return false;
  }
  if (v->n_integers > 0 &&
      !accept(e, u, u->call.get_integer(u->instance, integers, v->n_integers, u->whole),
              "fmi2GetInteger", t)) {
    return false;
  }
  if (v->n_booleans > 0 &&
      !accept(e, u, u->call.get_boolean(u->instance, booleans, v->n_booleans, flags),
              "fmi2GetBoolean", t)) {
    return false;
  }
  for (i = 0; i < v->n_integers; i++) {
    values[v->n_reals + i] = u->whole[i];
  }
  for (i = 0; i < v->n_booleans; i++) {
    values[v->n_reals + v->n_integers + i] = flags[i] != fmi2False;
  }
  return true;
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
  if (!set_values(e, u, &d->parameters, d->values, &OF_PARAMETERS, 0.0)) {
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
  size_t n_inputs, n_whole;
  u->description = d;
  if (is_host(d)) {
    return true;
  }
  n_inputs = count_of(&d->inputs);
  n_whole = count_of(&d->parameters) + n_inputs + count_of(&d->outputs);
  u->inputs = calloc(n_inputs > 0 ? n_inputs : 1, sizeof *u->inputs);
  u->whole = calloc(n_whole > 0 ? n_whole : 1, sizeof *u->whole);
  if (u->inputs == NULL || u->whole == NULL) {
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
  free(u->whole);
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

/* Seconds since *begin, which becomes now: one reading ends a unit and begins the next one. */
static double since(const executor *e, double *begin) {
  const double now = clock_now(e);
  const double spent = now - *begin;
  *begin = now;
  return spent;
}

bool executor_publish(executor *e, size_t component, int64_t n) {
  unit *u = &e->units[component];
  const executor_component *d = u->description;
  return u->instance == NULL ||
         get_values(e, u, &d->outputs, e->bus + d->slot, (double)n * e->base);
}

bool executor_feed(executor *e, size_t component, int64_t n) {
  unit *u = &e->units[component];
  const executor_component *d = u->description;
  const size_t n_inputs = count_of(&d->inputs);
  size_t i;
  if (u->instance == NULL) {
    return true;
  }
  for (i = 0; i < n_inputs; i++) {
    u->inputs[i] = e->bus[d->sources[i]];
  }
  return set_values(e, u, &d->inputs, u->inputs, &OF_INPUTS, (double)n * e->base);
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

void executor_play(executor *e, const double *rows, size_t n_rows, size_t slot, size_t n_slots) {
  e->played = rows;
  e->n_rows = n_rows;
  e->played_slot = slot;
  e->n_played = n_slots;
}

static void play(executor *e) {
  if (e->n_rows > 0) {
    const size_t last = e->n_rows - 1, now = (size_t)e->now;
    const double *row = e->played + (now < last ? now : last) * e->n_played;
    memcpy(e->bus + e->played_slot, row, e->n_played * sizeof *row);
  }
}

static bool publish_due(executor *e) {
  size_t k;
  double begin = clock_now(e);
  for (k = 0; k < e->n_units; k++) {
    unit *u = &e->units[k];
    if (e->now % u->description->period == 0) {
      if (!executor_publish(e, k, e->now)) {
        return false;
      }
      u->times.seconds += since(e, &begin);
    }
  }
  play(e);
  return append_rows(e);
}

static bool step_due(executor *e) {
  size_t k;
  double begin = clock_now(e);
  for (k = 0; k < e->n_units; k++) {
    unit *u = &e->units[k];
    if (e->now % u->description->period == 0) {
      double spent;
      if (!executor_feed(e, k, e->now) || !executor_advance(e, k, e->now)) {
        return false;
      }
      spent = since(e, &begin);
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

fmi2Component executor_instance(const executor *e, size_t component) {
  return e->units[component].instance;
}

executor_times executor_time_of(const executor *e, size_t component) {
  return e->units[component].times;
}
