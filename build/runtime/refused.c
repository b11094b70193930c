/* Functions that FMI demands and that have nothing to do here: there are no Strings, no
   derivatives are offered, and every step is complete when fmi2DoStep returns. */
#include "instance.h"

/* fmi2OK for nothing at all, else an error that says what is missing */
static fmi2Status unless_empty(fmi2Component c, flexhex_call call, size_t n, const char *why) {
  flexhex_instance *m = flexhex_enter(c, call);
  if (!m) {
    return fmi2Error;
  }
  return n == 0 ? fmi2OK : flexhex_refuse(m, "%s: %s", flexhex_call_name(call), why);
}

static const char NO_STRING[] = "this FMU has no String variables";

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[]) {
  (void)vr, (void)value;
  return unless_empty(c, FLEXHEX_GET_STRING, nvr, NO_STRING);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
  (void)vr, (void)value;
  return unless_empty(c, FLEXHEX_SET_STRING, nvr, NO_STRING);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[],
                                        size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
  (void)vUnknown_ref, (void)vKnown_ref, (void)nKnown, (void)dvKnown, (void)dvUnknown;
  return unless_empty(c, FLEXHEX_GET_DIRECTIONAL_DERIVATIVE, nUnknown,
                      "not offered (providesDirectionalDerivative is false)");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
  (void)vr, (void)order, (void)value;
  return unless_empty(c, FLEXHEX_SET_REAL_INPUT_DERIVATIVES, nvr,
                      "inputs are held, not interpolated (canInterpolateInputs is false)");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
  (void)vr, (void)order, (void)value;
  return unless_empty(c, FLEXHEX_GET_REAL_OUTPUT_DERIVATIVES, nvr,
                      "outputs have no derivatives (maxOutputDerivativeOrder is 0)");
}

/* Status: the instance when value can be written. fmi2Discard means: not known of this kind. */
static flexhex_instance *status_query(fmi2Component c, flexhex_call call, const void *value) {
  flexhex_instance *m = flexhex_enter(c, call);
  if (m && !value) {
    (void)flexhex_refuse(m, "%s: value is NULL", flexhex_call_name(call));
    return NULL;
  }
  return m;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
  if (!status_query(c, FLEXHEX_GET_STATUS, value)) {
    return fmi2Error;
  }
  if (s != fmi2DoStepStatus) {
    return fmi2Discard;
  }
  *value = fmi2OK;
  return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
  (void)s;
  return status_query(c, FLEXHEX_GET_INTEGER_STATUS, value) ? fmi2Discard : fmi2Error;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
  if (!status_query(c, FLEXHEX_GET_BOOLEAN_STATUS, value)) {
    return fmi2Error;
  }
  if (s != fmi2Terminated) {
    return fmi2Discard;
  }
  *value = fmi2False;
  return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
  if (!status_query(c, FLEXHEX_GET_STRING_STATUS, value)) {
    return fmi2Error;
  }
  if (s != fmi2PendingStatus) {
    return fmi2Discard;
  }
  *value = "";
  return fmi2OK;
}
