/* Life cycle of an instance: instantiate, set up, initialise, terminate, reset, free. */
#include "instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double LATEST =
    562949953421312.0; /* 2^49 base steps: a double still resolves eighths */

const char *fmi2GetTypesPlatform(void) {
  return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
  return fmi2Version;
}

static size_t rounded(size_t size) {
  return (size + 15) / 16 * 16;
}

static size_t count_of(const flexhex_variable *v) {
  return v->size ? (size_t)v->size : 1;
}

/* Number of scalars of the kinds from..to */
static size_t total(flexhex_kind from, flexhex_kind to) {
  size_t n = 0;
  for (int k = 0; k < FLEXHEX_MODEL.n_variables; ++k) {
    const flexhex_variable *v = &FLEXHEX_MODEL.variables[k];
    n += v->kind >= from && v->kind <= to ? count_of(v) : 0;
  }
  return n;
}

/* A struct of step.c is as large as its variables; one without any holds a single double. */
static bool fits(size_t bytes, size_t n) {
  return bytes == (n ? n : 1) * sizeof(double);
}

static bool is_consistent(void) {
  const flexhex_model *model = &FLEXHEX_MODEL;
  return total(FLEXHEX_FIXED, FLEXHEX_OUTPUT) == (size_t)model->n_values &&
         fits(model->block->parameters, total(FLEXHEX_FIXED, FLEXHEX_TUNABLE)) &&
         fits(model->block->inputs, total(FLEXHEX_INPUT, FLEXHEX_INPUT)) &&
         fits(model->block->outputs, total(FLEXHEX_OUTPUT, FLEXHEX_OUTPUT));
}

/* As instantiated: start values, time zero, logging as requested there */
static void make_fresh(flexhex_instance *m) {
  memset(m->head, 0, m->block_size);
  memcpy(m->values, FLEXHEX_MODEL.starts, m->n_values * sizeof *m->values);
  m->head->phase = FLEXHEX_INSTANTIATED;
  m->head->stop_time = INFINITY;
  m->logging = m->first_logging;
}

/* One allocation holds the instance, its block, the lookup of variables and its name. */
static flexhex_instance *allocate(const fmi2CallbackFunctions *functions, const char *name) {
  const flexhex_model *model = &FLEXHEX_MODEL;
  const size_t n = (size_t)model->n_values, n_outputs = total(FLEXHEX_OUTPUT, FLEXHEX_OUTPUT);
  const size_t at_block = rounded(sizeof(flexhex_instance));
  const size_t at_state = rounded(sizeof(flexhex_head) + (n + n_outputs) * sizeof(double));
  const size_t block = at_state + rounded(model->block->state);
  const size_t n_lookup = n + (size_t)model->n_variables;
  const size_t size = at_block + block + n_lookup * sizeof(int) + strlen(name) + 1;
  /* both of the importer's functions, or neither */
  const bool theirs = functions->allocateMemory && functions->freeMemory;
  char *memory = (char *)(theirs ? functions->allocateMemory(1, size) : calloc(1, size));
  if (!memory) {
    return NULL;
  }
  memset(memory, 0, size);
  flexhex_instance *m = (flexhex_instance *)(void *)memory;
  m->functions = *functions;
  if (!theirs) {
    m->functions.allocateMemory = NULL;
    m->functions.freeMemory = NULL;
  }
  m->magic = FLEXHEX_MAGIC;
  m->block_size = block;
  m->head = (flexhex_head *)(void *)(memory + at_block);
  m->values = (double *)(void *)(m->head + 1);
  m->pending = m->values + n;
  m->state = memory + at_block + at_state;
  m->inputs = m->values + total(FLEXHEX_FIXED, FLEXHEX_TUNABLE);
  m->outputs = m->values + (n - n_outputs);
  m->n_values = (unsigned)n;
  m->n_outputs = (unsigned)n_outputs;
  m->first_output = (unsigned)(n - n_outputs);
  m->owner = (int *)(void *)(memory + at_block + block);
  m->first = m->owner + n;
  m->name = (char *)(m->owner + n_lookup);
  memcpy(m->name, name, strlen(name) + 1);
  return m;
}

static void index_variables(flexhex_instance *m) {
  int reference = 0;
  for (int k = 0; k < FLEXHEX_MODEL.n_variables; ++k) {
    m->first[k] = reference;
    for (size_t i = 0; i < count_of(&FLEXHEX_MODEL.variables[k]); ++i) {
      m->owner[reference++] = k;
    }
  }
}

/* Why the arguments of fmi2Instantiate are refused; NULL when they are good. */
static const char *objection(fmi2String name, fmi2Type type, fmi2String guid) {
  if (!name || !name[0]) {
    return "fmi2Instantiate: the instance has no name";
  }
  if (type != fmi2CoSimulation) {
    return "fmi2Instantiate: this FMU is for co-simulation only";
  }
  if (!guid || strcmp(guid, FLEXHEX_MODEL.guid) != 0) {
    return "fmi2Instantiate: the GUID is not that of this binary; modelDescription.xml and"
           " binary are of different builds";
  }
  return is_consistent() ? NULL : "fmi2Instantiate: the table of variables does not fit step.c";
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn) {
  (void)fmuResourceLocation, (void)visible;
  if (!functions) {
    return NULL;
  }
  const char *why = objection(instanceName, fmuType, fmuGUID);
  flexhex_instance *m = why ? NULL : allocate(functions, instanceName);
  if (!m) {
    flexhex_say(functions, instanceName ? instanceName : FLEXHEX_MODEL.identifier, fmi2Error,
                flexhex_categories[FLEXHEX_ERRORS], why ? why : "fmi2Instantiate: out of memory");
    return NULL;
  }
  index_variables(m);
  m->first_logging = loggingOn ? FLEXHEX_ALL_CATEGORIES : 0;
  make_fresh(m);
  flexhex_log(m, fmi2OK, FLEXHEX_EVENTS, "%s instantiated", FLEXHEX_MODEL.identifier);
  return m;
}

void fmi2FreeInstance(fmi2Component c) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_FREE_INSTANCE);
  if (!m) {
    return;
  }
  m->magic = 0;
  if (m->functions.freeMemory) {
    m->functions.freeMemory(m);
  } else {
    free(m);
  }
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_SET_DEBUG_LOGGING);
  if (!m) {
    return fmi2Error;
  }
  int chosen = nCategories ? 0 : FLEXHEX_ALL_CATEGORIES;
  for (size_t k = 0; k < nCategories; ++k) {
    const char *name = categories && categories[k] ? categories[k] : "NULL";
    int category = 0;
    for (int i = 0; i < FLEXHEX_N_CATEGORIES; ++i) {
      category |= strcmp(name, flexhex_categories[i]) == 0 ? 1 << i : 0;
    }
    if (!category) {
      return flexhex_refuse(m, "fmi2SetDebugLogging: no category %s; there are %s, %s, %s", name,
                            flexhex_categories[0], flexhex_categories[1], flexhex_categories[2]);
    }
    chosen |= category;
  }
  m->logging = loggingOn ? chosen : 0;
  return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
  (void)toleranceDefined, (void)tolerance;
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_SETUP_EXPERIMENT);
  if (!m) {
    return fmi2Error;
  }
  const double stop = stopTimeDefined ? stopTime : INFINITY;
  if (!isfinite(startTime) || !(stop >= startTime)) {
    char a[FLEXHEX_NUMBER_SIZE], b[FLEXHEX_NUMBER_SIZE];
    return flexhex_refuse(m, "fmi2SetupExperiment: from %s s to %s s, must be finite and in order",
                          flexhex_number(a, startTime), flexhex_number(b, stop));
  }
  if (fabs(startTime) > FLEXHEX_MODEL.base_step * LATEST) {
    char a[FLEXHEX_NUMBER_SIZE], b[FLEXHEX_NUMBER_SIZE];
    return flexhex_refuse(m, "fmi2SetupExperiment: base steps of %s s are lost beside %s s",
                          flexhex_number(b, FLEXHEX_MODEL.base_step), flexhex_number(a, startTime));
  }
  m->head->start_time = startTime;
  m->head->stop_time = stop;
  return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_ENTER_INITIALIZATION_MODE);
  if (!m) {
    return fmi2Error;
  }
  m->head->phase = FLEXHEX_INITIALIZATION_MODE;
  return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_EXIT_INITIALIZATION_MODE);
  if (!m || !flexhex_start(m)) {
    return fmi2Error;
  }
  m->head->phase = FLEXHEX_STEP_COMPLETE;
  flexhex_log(m, fmi2OK, FLEXHEX_EVENTS, "initialised, %lld base steps per sample time",
              (long long)m->head->period);
  return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_TERMINATE);
  if (!m) {
    return fmi2Error;
  }
  m->head->phase = FLEXHEX_TERMINATED;
  flexhex_log(m, fmi2OK, FLEXHEX_EVENTS, "terminated");
  return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_RESET);
  if (!m) {
    return fmi2Error;
  }
  flexhex_log(m, fmi2OK, FLEXHEX_EVENTS, "reset");
  make_fresh(m);
  return fmi2OK;
}
