/* fmi2GetReal and fmi2SetReal: a call is checked whole before anything is stored. */
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

/* An output, or a fixed parameter after the initialisation */
static fmi2Status refuse_kind(flexhex_instance *m, fmi2ValueReference vr) {
  char text[LABEL_SIZE];
  if (variable_of(m, vr)->kind == FLEXHEX_OUTPUT) {
    return flexhex_refuse(m, "fmi2SetReal: %s is an output and cannot be set", label(m, vr, text));
  }
  return flexhex_refuse(m,
                        "fmi2SetReal: %s is a fixed parameter, set it before"
                        " fmi2ExitInitializationMode",
                        label(m, vr, text));
}

static fmi2Status refuse_value(flexhex_instance *m, fmi2ValueReference vr, double value) {
  const flexhex_variable *v = variable_of(m, vr);
  const bool plain = strcmp(v->unit, "1") == 0;
  const char *space = plain ? "" : " ", *unit = plain ? "" : v->unit;
  char text[LABEL_SIZE], number[FLEXHEX_NUMBER_SIZE], low[FLEXHEX_NUMBER_SIZE];
  char high[FLEXHEX_NUMBER_SIZE];
  const char *name = label(m, vr, text), *is = flexhex_number(number, value);
  if (v->min <= -DBL_MAX && v->max >= DBL_MAX) {
    return flexhex_refuse(m, "%s = %s%s%s, must be finite", name, is, space, unit);
  }
  return flexhex_refuse(m, "%s = %s%s%s, allowed %s to %s%s%s", name, is, space, unit,
                        flexhex_number(low, v->min), flexhex_number(high, v->max), space, unit);
}

/* True when the references follow one another, as importers that read arrays pass them. */
static bool is_run(const fmi2ValueReference vr[], size_t nvr) {
  fmi2ValueReference off = 0;
  for (size_t k = 0; k < nvr; ++k) {
    off |= vr[k] - vr[0] - (fmi2ValueReference)k;
  }
  return nvr > 0 && off == 0 && vr[nvr - 1] >= vr[0]; /* not wrapped around */
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       fmi2Real value[]) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_GET_REAL);
  if (!m) {
    return fmi2Error;
  }
  if (nvr > 0 && (!vr || !value)) {
    return refuse_array(m, FLEXHEX_GET_REAL);
  }
  const bool run = is_run(vr, nvr);
  fmi2ValueReference last = run ? vr[nvr - 1] : 0;
  for (size_t k = 0; !run && k < nvr; ++k) {
    last = vr[k] > last ? vr[k] : last;
  }
  if (last >= m->n_values) {
    return refuse_reference(m, FLEXHEX_GET_REAL, last);
  }
  const bool outputs = nvr > 0 && last >= m->first_output;
  /* initial outputs follow the parameters for as long as those can change */
  if (outputs && m->head->phase == FLEXHEX_INITIALIZATION_MODE && !flexhex_start(m)) {
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

static bool may_set(const flexhex_instance *m, const flexhex_variable *v) {
  return v->kind == FLEXHEX_INPUT || v->kind == FLEXHEX_TUNABLE ||
         (v->kind == FLEXHEX_FIXED && m->head->phase != FLEXHEX_STEP_COMPLETE);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[]) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_SET_REAL);
  if (!m) {
    return fmi2Error;
  }
  if (nvr > 0 && (!vr || !value)) {
    return refuse_array(m, FLEXHEX_SET_REAL);
  }
  /* the variable that was looked up last: its references and what it accepts */
  fmi2ValueReference first = 0, count = 0;
  double low = 0.0, high = 0.0;
  for (size_t k = 0; k < nvr; ++k) {
    if (vr[k] - first >= count) {
      if (vr[k] >= m->n_values) {
        return refuse_reference(m, FLEXHEX_SET_REAL, vr[k]);
      }
      const flexhex_variable *v = variable_of(m, vr[k]);
      if (!may_set(m, v)) {
        return refuse_kind(m, vr[k]);
      }
      first = (fmi2ValueReference)m->first[m->owner[vr[k]]];
      count = v->size ? (fmi2ValueReference)v->size : 1;
      low = v->min;
      high = v->max;
    }
    /* written so that NaN is refused too */
    if (!(value[k] >= low && value[k] <= high)) {
      return refuse_value(m, vr[k], value[k]);
    }
  }
  if (is_run(vr, nvr)) {
    memcpy(m->values + vr[0], value, nvr * sizeof *value);
    return fmi2OK;
  }
  for (size_t k = 0; k < nvr; ++k) {
    m->values[vr[k]] = value[k];
  }
  return fmi2OK;
}
