/* The timing rule: time is a whole number of base steps. At a tick k Ts, k >= 1, the inputs are
   sampled; the results appear at (k + 1) Ts, whatever steps the importer takes in between. */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double MOST_STEPS = 9007199254740992.0; /* 2^53: counts beyond are not exact */

/* Base steps per Ts; 0, refused, when Ts is not a whole number of them. */
static int64_t period_of(flexhex_instance *m) {
  const double Ts = m->values[0], count = Ts / FLEXHEX_MODEL.base_step, whole = round(count);
  if (whole >= 1.0 && whole < MOST_STEPS && fabs(count - whole) <= 1e-6) {
    return (int64_t)whole;
  }
  char is[FLEXHEX_NUMBER_SIZE], base[FLEXHEX_NUMBER_SIZE];
  (void)flexhex_refuse(m, "Ts = %s s, must be a whole number of base steps of %s s",
                       flexhex_number(is, Ts), flexhex_number(base, FLEXHEX_MODEL.base_step));
  return 0;
}

bool flexhex_start(flexhex_instance *m) {
  const flexhex_block *block = FLEXHEX_MODEL.block;
  char message[256] = "";
  m->head->period = period_of(m);
  if (m->head->period == 0) {
    return false;
  }
  memset(m->pending, 0, m->n_outputs * sizeof *m->pending);
  memset(m->state, 0, block->state);
  if (!block->start(m->values, m->state, m->pending, message, sizeof message)) {
    (void)flexhex_refuse(m, "%s", message[0] ? message : "a parameter is wrong");
    return false;
  }
  flexhex_publish(m);
  return true;
}

void flexhex_publish(flexhex_instance *m) {
  memcpy(m->outputs, m->pending, m->n_outputs * sizeof *m->outputs);
  if (m->head->refused && m->outputs[m->n_outputs - 1] == 0.0) {
    m->outputs[m->n_outputs - 1] = 1.0;
  }
}

static double time_of(const flexhex_instance *m, int64_t step) {
  return m->head->start_time + (double)step * FLEXHEX_MODEL.base_step;
}

/* A fault of step.c that was not there a period ago */
static void warn_of_fault(const flexhex_instance *m, int64_t step) {
  const double fault = m->pending[m->n_outputs - 1], before = m->outputs[m->n_outputs - 1];
  if (fault != before && fault != 0.0) {
    const bool named = fault > 0.0 && fault < FLEXHEX_MODEL.n_faults;
    char number[FLEXHEX_NUMBER_SIZE], time[FLEXHEX_NUMBER_SIZE];
    flexhex_log(m, fmi2Warning, FLEXHEX_WARNINGS, "fault = %s (%s) from %s s on",
                flexhex_number(number, fault),
                named ? FLEXHEX_MODEL.faults[(int)fault] : "not declared",
                flexhex_number(time, time_of(m, step)));
  }
}

/* From one multiple of the period to the next: the base steps between do nothing. */
static void advance(flexhex_instance *m, int64_t end) {
  flexhex_head *head = m->head;
  for (int64_t now = head->step; now < end;) {
    const int64_t ticks = now / head->period;
    if (now > 0 && now == ticks * head->period) {
      FLEXHEX_MODEL.block->tick(m->values, m->inputs, m->state, m->pending);
    }
    now = (ticks + 1) * head->period;
    if (now <= end) {
      warn_of_fault(m, now);
      flexhex_publish(m);
    }
  }
  head->step = end;
}

/* How far [base steps] an importer's time may be from a whole count. A sum of n steps rounds n
   times, each time by at most half a unit in the last place of the time t reached, in all
   n DBL_EPSILON/2 |t|. Twice that, and a few roundings more, leave room for a step size that is
   itself rounded and for the operations here. Not less than REST, a step that nobody means to take.
   From a quarter of a step on the count is in doubt. */
static double slack(const flexhex_instance *m, double count) {
  enum { OTHERS = 4 };
  static const double REST = 1e-9;
  const double reached = fabs(m->head->start_time) / FLEXHEX_MODEL.base_step + count + 1.0;
  return fmin(0.25, fmax(REST, DBL_EPSILON * (count + OTHERS) * reached));
}

/* Base steps from the start to the importer's time [s]; -1 when it is not a whole number. */
static int64_t count_at(const flexhex_instance *m, double time) {
  const double count = (time - m->head->start_time) / FLEXHEX_MODEL.base_step;
  const double whole = floor(count + 0.5);
  /* written so that NaN is not whole either */
  const bool known = whole >= 0.0 && whole < MOST_STEPS && fabs(count - whole) <= slack(m, whole);
  return known ? (int64_t)whole : -1;
}

/* True when a step from `time` to the count `end` goes beyond the stop time. An importer that
   sums its time can believe to be short of it and take one step more: that is let through. */
static bool is_past_stop(const flexhex_instance *m, double time, int64_t end) {
  const double stop = m->head->stop_time;
  if (isinf(stop)) {
    return false;
  }
  const double last = (stop - m->head->start_time) / FLEXHEX_MODEL.base_step + 0.25;
  return (double)end > last && !(time < stop && (double)m->head->step > last - 0.5);
}

/* What fmi2DoStep answers before anything is done. fmi2Discard would say that a part of the step
   was done (FMI 2.0.3, 4.2.1), and importers would ask for the rest of it. */
static fmi2Status judge(flexhex_instance *m, double time, double size, int64_t end) {
  char a[FLEXHEX_NUMBER_SIZE], b[FLEXHEX_NUMBER_SIZE];
  if (count_at(m, time) != m->head->step) {
    return flexhex_refuse(m, "fmi2DoStep from %s s, but the FMU is at %s s",
                          flexhex_number(a, time), flexhex_number(b, time_of(m, m->head->step)));
  }
  if (!(size > 0.0 && isfinite(size))) {
    return flexhex_refuse(m, "fmi2DoStep by %s s, must be above zero and finite",
                          flexhex_number(a, size));
  }
  if (end < 0) {
    return flexhex_refuse(m, "fmi2DoStep by %s s, must be a whole number of base steps of %s s",
                          flexhex_number(a, size), flexhex_number(b, FLEXHEX_MODEL.base_step));
  }
  if (end > m->head->step && is_past_stop(m, time, end)) {
    return flexhex_refuse(m, "fmi2DoStep to %s s, beyond the stop time %s s",
                          flexhex_number(a, time_of(m, end)),
                          flexhex_number(b, m->head->stop_time));
  }
  return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
  (void)noSetFMUStatePriorToCurrentPoint;
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_DO_STEP);
  if (!m) {
    return fmi2Error;
  }
  /* the step is judged by where it ends: what an importer's sum of times leaves over of the last
     step ends where the instance is, and does nothing */
  const int64_t end = count_at(m, currentCommunicationPoint + communicationStepSize);
  const fmi2Status status = judge(m, currentCommunicationPoint, communicationStepSize, end);
  if (status == fmi2OK) {
    advance(m, end);
  }
  return status;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
  return flexhex_enter(c, FLEXHEX_CANCEL_STEP) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_GET_REAL_STATUS);
  if (!m) {
    return fmi2Error;
  }
  if (!value) {
    return flexhex_refuse(m, "fmi2GetRealStatus: value is NULL");
  }
  if (s != fmi2LastSuccessfulTime) {
    return fmi2Discard;
  }
  *value = time_of(m, m->head->step);
  return fmi2OK;
}
