/* Several blocks as one FMU. Every part keeps its own sample time, counted in base steps, and what
   passes between parts passes as between FMUs: sampled at k Ts, k >= 1, shown at (k + 1) Ts,
   refused when it is NaN or out of range. The table of parts is generated. */
#include "controller.h"
#include "controller_parts.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct {
  int64_t ticks;
  int64_t period[N_PARTS]; /* base steps */
  double refused[N_PARTS]; /* 1: a part was handed a value that it does not allow */
  double inputs[N_INPUTS];
  double pending[N_OUTPUTS]; /* what the parts have computed */
  double bus[N_OUTPUTS];     /* what they show */
  double blocks[N_BLOCKS];   /* the states of the parts, one behind the other */
} state;

/* Base steps in the sample time of a part; 0 when it is no whole number of them. */
static int64_t period_of(double Ts) {
  const double count = Ts / BASE_STEP, whole = round(count);
  return whole >= 1.0 && whole < 1e9 && fabs(count - whole) <= 1e-6 ? (int64_t)whole : 0;
}

static bool fits(const part *q) {
  return q->block->inputs == q->n_inputs * sizeof(double) &&
         q->block->outputs == q->n_outputs * sizeof(double) &&
         q->block->state <= q->n_state * sizeof(double);
}

static bool start_part(const part *q, int64_t *period, const double *parameters, state *s,
                       char *message, size_t size) {
  char text[192] = "";
  *period = period_of(parameters[0]);
  if (*period == 0) {
    (void)snprintf(message, size,
                   "%s_Ts = %.17g s, must be a whole number of base steps of %.17g s", q->name,
                   parameters[0], BASE_STEP);
    return false;
  }
  if (!fits(q)) {
    (void)snprintf(message, size, "%s: compiled for a machine with larger numbers: build it there",
                   q->name);
    return false;
  }
  if (!q->block->start(parameters, s->blocks + q->state, s->pending + q->outputs, text,
                       sizeof text)) {
    (void)snprintf(message, size, "%s: %s", q->name, text[0] ? text : "a parameter is wrong");
    return false;
  }
  return true;
}

/* Outputs of the container from what the parts show; its fault is the highest of theirs. */
static void show(const state *s, controller_outputs *outputs) {
  double *y = (double *)outputs, highest = 0.0;
  for (int k = 0; k < N_SHOWN; ++k) {
    y[k] = s->bus[shown[k]];
  }
  for (int k = 0; k < N_PARTS; ++k) {
    const double fault = s->bus[parts[k].outputs + parts[k].n_outputs - 1];
    highest = fault > highest ? fault : highest;
  }
  outputs->fault = highest;
}

static bool start(const controller_parameters *p, void *memory, controller_outputs *y,
                  char *message, size_t size) {
  state *s = (state *)memory;
  const double *parameters = (const double *)p;
  if (period_of(p->Ts) != 1) {
    (void)snprintf(message, size, "Ts = %.17g s, must be the base step of %.17g s", p->Ts,
                   BASE_STEP);
    return false;
  }
  for (int k = 0; k < N_PARTS; ++k) {
    const part *q = &parts[k];
    if (!start_part(q, &s->period[k], parameters + q->parameters, s, message, size)) {
      return false;
    }
  }
  memcpy(s->bus, s->pending, sizeof s->bus);
  show(s, y);
  return true;
}

/* The inputs of a part, all of them or, when one is not allowed, none. */
static void feed_part(const part *q, double *refused, const double *u, state *s) {
  double values[MOST_INPUTS];
  for (size_t k = 0; k < q->n_inputs; ++k) {
    const feed *f = &feeds[q->inputs + k];
    values[k] = f->outside ? u[f->from] : s->bus[f->from];
    /* written so that NaN is refused too */
    if (!(values[k] >= f->low && values[k] <= f->high)) {
      *refused = 1.0;
      return;
    }
  }
  memcpy(s->inputs + q->inputs, values, q->n_inputs * sizeof values[0]);
}

static void publish(const part *q, double refused, state *s) {
  double *fault = &s->bus[q->outputs + q->n_outputs - 1];
  memcpy(s->bus + q->outputs, s->pending + q->outputs, q->n_outputs * sizeof s->bus[0]);
  *fault = *fault == 0.0 ? refused : *fault;
}

static void tick(const controller_parameters *p, const controller_inputs *u, void *memory,
                 controller_outputs *y) {
  state *s = (state *)memory;
  const double *parameters = (const double *)p;
  const int64_t now = ++s->ticks;
  for (int k = 0; k < N_PARTS; ++k) {
    if (now % s->period[k] == 0) {
      feed_part(&parts[k], &s->refused[k], (const double *)u, s);
    }
  }
  for (int k = 0; k < N_PARTS; ++k) {
    const part *q = &parts[k];
    if (now % s->period[k] == 0) {
      q->block->tick(parameters + q->parameters, s->inputs + q->inputs, s->blocks + q->state,
                     s->pending + q->outputs);
    }
    if ((now + 1) % s->period[k] == 0) {
      publish(q, s->refused[k], s);
    }
  }
  show(s, y);
}

FLEXHEX_BLOCK(controller, state, start, tick)
