/* Plant: quantised drives with a current loop, the mechanism integrated at fixed steps, encoders.

   A tick takes the state from kTs to (k+1)Ts under a torque command that is constant meanwhile.
   The current loop is solved in closed form (plant_drive); the mechanism takes one evaluation of
   its dynamics a substep (multistep.h), four after a start or a jump (motion.h), then d is put
   back on the constraints. */
#include "plant.h"

#include "hidden.h"
#include "multistep.h"

#include <math.h>
#include <string.h>

static const double FAULT_END_STOP = 2.0, FAULT_DIVERGED = 3.0;
/* more than this [rad] in one step, or a Dahl state beyond this (it is within 1), is no motion */
static const double LEAP = 1.0, LARGEST_Z = 2.0;
/* a pose whose constraints are further off than this is none; a Newton correction leaves its
   square, which is lost in rounding where they are nearer than CLOSE */
static const double OPEN = 1e-3, CLOSE = 4e-8;

typedef struct {
  motion now;
  history past;
  double tau_motor[N];
  double command[PLANT_MAX_DELAY + 1][N];
  double theta_read[PLANT_MAX_DELAY + 1][N];
  double tau_read[PLANT_MAX_DELAY + 1][N];
  double ticks;
  plant_hidden_state hidden;
#ifdef PLANT_N_EFFECT
  plant_effects effects;
#endif
} state;

/* value in whole steps; itself where there is no step, or one too fine to count */
static double quantised(double value, double step) {
  const double count = step > 0.0 ? value / step : INFINITY;
  return isfinite(count) ? step * nearbyint(count) : value;
}

static bool whole(const char *name, double value, char *message, size_t size) {
  if (value == floor(value)) {
    return true;
  }
  snprintf(message, size, "%s = %.17g, must be a whole number", name, value);
  return false;
}

static void read_sensors(const plant_parameters *p, state *s, plant_outputs *y) {
  const int delay = (int)p->measurement_delay, newest = (int)fmod(s->ticks, PLANT_MAX_DELAY + 1);
  const int oldest = (newest + PLANT_MAX_DELAY + 1 - delay) % (PLANT_MAX_DELAY + 1);
  const double *angle = s->now.of.theta;
#ifdef PLANT_N_EFFECT
  double reading[N];
  plant_effect_reading(angle, s->tau_motor, p->effect, reading);
  angle = reading;
#endif
  for (int i = 0; i < N; ++i) {
    s->theta_read[newest][i] = quantised(angle[i], p->theta_step);
    s->tau_read[newest][i] = plant_hidden_reading(p, &s->hidden, s->tau_motor[i]);
    s->tau_read[newest][i] = quantised(s->tau_read[newest][i], p->tau_step);
    y->theta[i] = s->theta_read[oldest][i];
    y->tau_meas[i] = s->tau_read[oldest][i];
  }
#if PLANT_N_D > 0
  plant_pose(s->now.of.d, y->x_E, y->phi_E);
#endif
}

static bool start(const plant_parameters *p, void *memory, plant_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
  if (!whole("substeps", p->substeps, message, size) ||
      !whole("command_delay", p->command_delay, message, size) ||
      !whole("measurement_delay", p->measurement_delay, message, size)) {
    return false;
  }
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  plant_neutral(s->now.of.d);
  history_start(p, &s->past);
  plant_hidden_start(p, &s->hidden);
#ifdef PLANT_N_EFFECT
  plant_effects_start(p, s->now.of.theta, &s->effects, s->now.of.effect);
  if (plant_effects_refuse(&s->effects, p->Ts / p->substeps, message, size)) {
    return false;
  }
#endif
  read_sensors(p, s, y);
  return true;
}

/* Input of the current loop: the command after delay, limit and quantisation. */
static void drive(const plant_parameters *p, const plant_inputs *u, state *s,
                  double tau_command[N]) {
  const int delay = (int)p->command_delay, newest = (int)fmod(s->ticks, PLANT_MAX_DELAY + 1);
  const int oldest = (newest + PLANT_MAX_DELAY + 1 - delay) % (PLANT_MAX_DELAY + 1);
  for (int i = 0; i < N; ++i) {
    s->command[newest][i] = u->tau[i];
    const double limited = fmax(-p->tau_max, fmin(p->tau_max, s->command[oldest][i]));
    tau_command[i] = quantised(limited, p->tau_step);
  }
}

/* True when the step is no plausible motion: h is too long for the equations. */
static bool diverged(const motion *before, const motion *now) {
  for (int k = 0; k < N_MOTION; ++k) {
    if (!isfinite(now->all[k])) {
      return true;
    }
  }
  for (int i = 0; i < N; ++i) {
    if (fabs(now->of.theta[i] - before->of.theta[i]) > LEAP || fabs(now->of.z[i]) > LARGEST_Z) {
      return true;
    }
  }
  return false;
}

/* Put d on the constraints; false in a pose that does not close, and beyond an end stop. */
static bool close_within_stroke(const plant_parameters *p, motion *now) {
  double residual = INFINITY;
  for (int k = 0; k < 3 && residual > CLOSE; ++k) {
    const motion open = *now;
    plant_close(open.of.theta, open.of.d, now->of.d, &residual);
    if (!(residual < OPEN)) {
      return false;
    }
  }
  for (int i = 0; i < N; ++i) {
    if (!(fabs(now->of.theta[i]) <= p->stroke)) {
      return false;
    }
  }
  return true;
}

/* A substep with one evaluation; false, and `now` is of no use, where the past does not lead on. */
static bool multistep(const plant_parameters *p, const action *a, history *past, motion *now) {
  const motion before = *now;
  predict(past, a, now);
  if (diverged(&before, now) || !close_within_stroke(p, now)) {
    return false;
  }
  remember(p, a, now, past);
  return correct(past, a, before.of.thetad, now) && !diverged(&before, now);
}

/* One substep; 0, or the fault for which it is not taken. */
static double substep(const plant_parameters *p, const action *a, history *past, motion *now) {
  const motion before = *now;
  if (a->payload != past->payload) {
    forget(past);
    past->payload = a->payload;
  }
  if (past->ahead == 0.0) {
    remember(p, a, now, past);
  }
  if (past->known == NODES) {
    if (multistep(p, a, past, now)) {
      return 0.0;
    }
    *now = before;
    forget(past);
    remember(p, a, now, past);
  }
  runge_kutta(p, a, past->slopes, now);
  past->ahead = 0.0;
  if (diverged(&before, now)) {
    return FAULT_DIVERGED;
  }
  return close_within_stroke(p, now) ? 0.0 : FAULT_END_STOP;
}

/* What acts in the substep of h at `time`; the torque of the motors at its end. */
static action acting(const plant_parameters *p, state *s, const double *command,
                     const double *disturbance, double payload, double time, double h) {
  action a;
  a.h = h, a.payload = payload;
  for (int i = 0; i < N; ++i) {
    a.level[i] = command[i] - disturbance[i];
    a.gap[i] = s->tau_motor[i] - command[i];
    a.tau[3][i] = command[i] / 2 + a.gap[i] * s->past.late;
  }
  a.level[N] = 1.0, a.gap[N] = 0.0;
  plant_drive(s->tau_motor, command, &p->f_current, &h, a.tau[0], a.tau[1], a.tau[2]);
  memcpy(s->tau_motor, a.tau[2], sizeof s->tau_motor);
#ifdef PLANT_N_EFFECT
  plant_transmit(&s->effects, command, p->f_current, time, h, a.tau);
  a.effects = &s->effects;
#else
  (void)time;
#endif
  for (int i = 0; i < 4 * N; ++i) {
    a.tau[i / N][i % N] -= disturbance[i % N] * (i / N < 3 ? 1.0 : 0.5);
  }
  return a;
}

static void tick(const plant_parameters *p, const plant_inputs *u, void *memory, plant_outputs *y) {
  state *s = (state *)memory;
  const int substeps = (int)p->substeps;
  const double h = p->Ts / substeps;
  double command[N], disturbance[N];
  drive(p, u, s, command);
  y->end_stop = y->fault = 0.0;
  plant_hidden_torque(p, &s->hidden, s->ticks * p->Ts, s->now.of.theta, s->tau_motor, disturbance);
  for (int k = 0; k < substeps; ++k) {
    const motion before = s->now;
    const action a = acting(p, s, command, disturbance, u->payload, s->ticks * p->Ts + k * h, h);
    const double fault = substep(p, &a, &s->past, &s->now);
    if (fault != 0.0) {
      /* the mechanism stands where it was and may leave at the next substep */
      s->now = before;
      memset(s->now.of.thetad, 0, sizeof s->now.of.thetad);
      forget(&s->past);
      y->fault = fault;
      y->end_stop = fault == FAULT_END_STOP ? 1.0 : y->end_stop;
    }
  }
  s->ticks += 1.0;
  read_sensors(p, s, y);
}

FLEXHEX_BLOCK(plant, state, start, tick)
