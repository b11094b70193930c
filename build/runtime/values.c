/* fmi2GetReal, fmi2SetReal and the like: a call is checked whole before anything is stored. */
#include "instance.h"

#include <string.h>

enum { LABEL_SIZE = 128 };

static const flexhex_variable *variable_of(const flexhex_instance *m, fmi2ValueReference vr) {
  return &FLEXHEX_MODEL.variables[m->owner[vr]];
}

/* `theta[3]`, `x_E.x` or `fault`, as modelDescription.xml names it */
static const char *label(const flexhex_instance *m, fmi2ValueReference vr, char *text) {
  const flexhex_variable *v = variable_of(m, vr);
  const int element = (int)vr - m->first[m->owner[vr]];
  if (v->elements) {
    (void)snprintf(text, LABEL_SIZE, "%s%s", v->name, v->elements[element]);
  } else if (v->size > 0) {
    (void)snprintf(text, LABEL_SIZE, "%s[%d]", v->name, element + 1);
  } else {
    (void)snprintf(text, LABEL_SIZE, "%s", v->name);
  }
  return text;
}

static fmi2Status refuse_array(flexhex_instance *m, flexhex_call call) {
  return flexhex_refuse(m, "%s: an array is NULL", flexhex_call_name(call));
}

static fmi2Status refuse_reference(flexhex_instance *m, flexhex_call call, fmi2ValueReference vr) {
  return flexhex_refuse(m, "%s: value reference %u does not exist, valid are 0 to %u",
                        flexhex_call_name(call), vr, m->n_values - 1);
}

static fmi2Status refuse_type(flexhex_instance *m, flexhex_call call, fmi2ValueReference vr) {
  static const char *const types[] = {"a Real", "an Integer or an enumeration", "a Boolean"};
  static const char *const functions[] = {"Real", "Integer", "Boolean"};
  const char *name = flexhex_call_name(call); /* fmi2Get or fmi2Set, then a type */
  const flexhex_type type = variable_of(m, vr)->type;
  char text[LABEL_SIZE];
  return flexhex_refuse(m, "%s: %s is %s, use %.7s%s", name, label(m, vr, text), types[type], name,
                        functions[type]);
}

/* An output, or a fixed parameter after the initialisation */
static fmi2Status refuse_kind(flexhex_instance *m, flexhex_call call, fmi2ValueReference vr) {
  char text[LABEL_SIZE];
  const char *name = flexhex_call_name(call);
  if (variable_of(m, vr)->kind == FLEXHEX_OUTPUT) {
    return flexhex_refuse(m, "%s: %s is an output and cannot be set", name, label(m, vr, text));
  }
  return flexhex_refuse(m, "%s: %s is a fixed parameter, set it before fmi2ExitInitializationMode",
                        name, label(m, vr, text));
}

static fmi2Status refuse_value(flexhex_instance *m, fmi2ValueReference vr, double value) {
  const flexhex_variable *v = variable_of(m, vr);
  const double least = v->least ? v->least[(int)vr - m->first[m->owner[vr]]] : v->min;
  const bool plain = strcmp(v->unit, "1") == 0;
  const char *space = plain ? "" : " ", *unit = plain ? "" : v->unit;
  char text[LABEL_SIZE], number[FLEXHEX_NUMBER_SIZE], low[FLEXHEX_NUMBER_SIZE];
  char high[FLEXHEX_NUMBER_SIZE];
  const char *name = label(m, vr, text), *is = flexhex_number(number, value);
  if (least <= -DBL_MAX && v->max >= DBL_MAX) {
    return flexhex_refuse(m, "%s = %s%s%s, must be finite", name, is, space, unit);
  }
  return flexhex_refuse(m, "%s = %s%s%s, allowed %s to %s%s%s", name, is, space, unit,
                        flexhex_number(low, least), flexhex_number(high, v->max), space, unit);
}

/* True when the references follow one another, as importers that read arrays pass them. */
static bool is_run(const fmi2ValueReference vr[], size_t nvr) {
  fmi2ValueReference off = 0;
  for (size_t k = 0; k < nvr; ++k) {
    off |= vr[k] - vr[0] - (fmi2ValueReference)k;
  }
  return nvr > 0 && off == 0 && vr[nvr - 1] >= vr[0]; /* not wrapped around */
}

/* Refused unless the variable of this reference is of the type. */
static bool is_of(flexhex_instance *m, flexhex_call call, flexhex_type type,
                  fmi2ValueReference vr) {
  if (vr >= m->n_values) {
    (void)refuse_reference(m, call, vr);
    return false;
  }
  if (variable_of(m, vr)->type != type) {
    (void)refuse_type(m, call, vr);
    return false;
  }
  return true;
}

/* The first reference behind the variable that this one belongs to */
static fmi2ValueReference behind(const flexhex_instance *m, fmi2ValueReference vr) {
  const int size = variable_of(m, vr)->size;
  return (fmi2ValueReference)(m->first[m->owner[vr]] + (size ? size : 1));
}

/* False, refused, when an array is missing, or a reference is no variable of the type. All of an
   array are of one type: of references that follow one another one is looked up in each array. */
static bool are_of(flexhex_instance *m, flexhex_call call, flexhex_type type,
                   const fmi2ValueReference vr[], size_t nvr, const void *value, bool run) {
  if (nvr > 0 && (!vr || !value)) {
    (void)refuse_array(m, call);
    return false;
  }
  for (size_t k = 0; k < nvr;) {
    if (!is_of(m, call, type, vr[k])) {
      return false;
    }
    k = run ? behind(m, vr[k]) - vr[0] : k + 1;
  }
  return true;
}

/* The instance when these can be read; initial outputs follow the parameters for as long as those
   can change. */
static const flexhex_instance *readable(fmi2Component c, flexhex_call call, flexhex_type type,
                                        const fmi2ValueReference vr[], size_t nvr,
                                        const void *value, bool run) {
  flexhex_instance *m = flexhex_enter(c, call);
  if (!m || !are_of(m, call, type, vr, nvr, value, run)) {
    return NULL;
  }
  if (m->head->phase != FLEXHEX_INITIALIZATION_MODE) {
    return m;
  }
  bool outputs = false;
  for (size_t k = 0; k < nvr; ++k) {
    outputs |= vr[k] >= m->first_output;
  }
  return outputs && !flexhex_start(m) ? NULL : m;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       fmi2Real value[]) {
  const bool run = vr && is_run(vr, nvr);
  const flexhex_instance *m = readable(c, FLEXHEX_GET_REAL, FLEXHEX_REAL, vr, nvr, value, run);
  if (!m) {
    return fmi2Error;
  }
  if (run) {
    memcpy(value, m->values + vr[0], nvr * sizeof *value);
    return fmi2OK;
  }
  for (size_t k = 0; k < nvr; ++k) {
    value[k] = m->values[vr[k]];
  }
  return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Integer value[]) {
  const flexhex_instance *m =
      readable(c, FLEXHEX_GET_INTEGER, FLEXHEX_INTEGER, vr, nvr, value, false);
  for (size_t k = 0; m && k < nvr; ++k) {
    value[k] = (fmi2Integer)m->values[vr[k]];
  }
  return m ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Boolean value[]) {
  const flexhex_instance *m =
      readable(c, FLEXHEX_GET_BOOLEAN, FLEXHEX_BOOLEAN, vr, nvr, value, false);
  for (size_t k = 0; m && k < nvr; ++k) {
    value[k] = m->values[vr[k]] != 0.0 ? fmi2True : fmi2False;
  }
  return m ? fmi2OK : fmi2Error;
}

static bool may_set(const flexhex_instance *m, const flexhex_variable *v) {
  return v->kind == FLEXHEX_INPUT || v->kind == FLEXHEX_TUNABLE ||
         (v->kind == FLEXHEX_FIXED && m->head->phase != FLEXHEX_STEP_COMPLETE);
}

/* fmi2Integer and fmi2Boolean are int; a Boolean other than 0 and 1 is refused by its range. */
static double element(flexhex_type type, const void *array, size_t k) {
  return type == FLEXHEX_REAL ? ((const fmi2Real *)array)[k] : ((const int *)array)[k];
}

static fmi2Status set_values(fmi2Component c, flexhex_call call, flexhex_type type,
                             const fmi2ValueReference vr[], size_t nvr, const void *array) {
  flexhex_instance *m = flexhex_enter(c, call);
  const bool run = type == FLEXHEX_REAL && vr && is_run(vr, nvr);
  if (!m || !are_of(m, call, type, vr, nvr, array, run)) {
    return fmi2Error;
  }
  /* the variable that was looked up last: its references and what it accepts */
  fmi2ValueReference first = 0, count = 0;
  double low = 0.0, high = 0.0;
  const double *least = NULL;
  for (size_t k = 0; k < nvr; ++k) {
    if (vr[k] - first >= count) {
      const flexhex_variable *v = variable_of(m, vr[k]);
      if (!may_set(m, v)) {
        return refuse_kind(m, call, vr[k]);
      }
      first = (fmi2ValueReference)m->first[m->owner[vr[k]]];
      count = v->size ? (fmi2ValueReference)v->size : 1;
      low = v->min;
      high = v->max;
      least = v->least;
    }
    low = least ? least[vr[k] - first] : low;
    const double value = element(type, array, k);
    /* written so that NaN is refused too */
    if (!(value >= low && value <= high)) {
      return refuse_value(m, vr[k], value);
    }
  }
  if (run) {
    memcpy(m->values + vr[0], array, nvr * sizeof *m->values);
    return fmi2OK;
  }
  for (size_t k = 0; k < nvr; ++k) {
    m->values[vr[k]] = element(type, array, k);
  }
  return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[]) {
  return set_values(c, FLEXHEX_SET_REAL, FLEXHEX_REAL, vr, nvr, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[]) {
  return set_values(c, FLEXHEX_SET_INTEGER, FLEXHEX_INTEGER, vr, nvr, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[]) {
  return set_values(c, FLEXHEX_SET_BOOLEAN, FLEXHEX_BOOLEAN, vr, nvr, value);
}
