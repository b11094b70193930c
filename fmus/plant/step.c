/* Plant: quantised drives with a current loop, the mechanism integrated at fixed steps, encoders.

   A tick takes the state from kTs to (k+1)Ts under a torque command that is constant meanwhile.
   The current loop is solved in closed form (plant_drive); the mechanism is stepped by the
   classical Runge-Kutta scheme on (theta, thetad, d, z), then d is put back on the constraints. */
#include "plant.h"

#include "effects.h"
#include "hidden.h"

#include <math.h>
#include <string.h>

/* C has no empty array: a machine without a platform has one d, which stays zero */
enum { N = PLANT_N, N_D = PLANT_N_D > 0 ? PLANT_N_D : 1 };
static const double FAULT_END_STOP = 2.0, FAULT_DIVERGED = 3.0;
/* more than this [rad] in one step, or a Dahl state beyond this (it is within 1), is no motion */
static const double LEAP = 1.0, LARGEST_Z = 2.0;

/* the state that is integrated: by name in the equations, as one vector in the integrator */
typedef struct {
  double theta[N], thetad[N], d[N_D], z[N];
#ifdef PLANT_N_EFFECT
  double effect[PLANT_N_EFFECT_STATE];
#endif
} motion_parts;
enum { N_MOTION = sizeof(motion_parts) / sizeof(double) };
typedef union {
  motion_parts of;
  double all[N_MOTION];
} motion;

typedef struct {
  motion now;
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
  plant_effect_reading(angle, p->effect, reading);
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

/* stage: 0 at the start of a substep, 1 in its middle, 2 at its end */
static void derive(const plant_parameters *p, const state *s, const motion *at, int stage,
                   double tau[3][N], double payload, motion *rate) {
  memcpy(rate->of.theta, at->of.thetad, sizeof rate->of.theta);
#if PLANT_N_D == 0
  rate->of.d[0] = 0.0;
#endif
#ifdef PLANT_N_EFFECT
  const plant_effects *e = &s->effects;
  plant_rates(at->of.theta, at->of.thetad, at->of.d, at->of.z, tau[stage], p->mechanism,
              p->actuator, &payload, e->motor[stage], e->taud, &e->time[stage], at->of.effect,
              p->effect, rate->of.thetad, rate->of.d, rate->of.z, rate->of.effect);
#else
  (void)s;
  plant_rates(at->of.theta, at->of.thetad, at->of.d, at->of.z, tau[stage], p->mechanism,
              p->actuator, &payload, rate->of.thetad, rate->of.d, rate->of.z);
#endif
}

static motion moved(const motion *from, double h, const motion *rate) {
  motion to;
  for (int k = 0; k < N_MOTION; ++k) {
    to.all[k] = from->all[k] + h * rate->all[k];
  }
  return to;
}

/* One Runge-Kutta step of h; tau at its start, middle and end. */
static void integrate(const plant_parameters *p, state *s, double tau[3][N], double payload,
                      double h) {
  motion *now = &s->now;
  motion k1, k2, k3, k4, at;
  derive(p, s, now, 0, tau, payload, &k1);
  at = moved(now, h / 2, &k1);
  derive(p, s, &at, 1, tau, payload, &k2);
  at = moved(now, h / 2, &k2);
  derive(p, s, &at, 1, tau, payload, &k3);
  at = moved(now, h, &k3);
  derive(p, s, &at, 2, tau, payload, &k4);
  for (int k = 0; k < N_MOTION; ++k) {
    now->all[k] += h / 6 * (k1.all[k] + 2 * (k2.all[k] + k3.all[k]) + k4.all[k]);
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

/* False when the step ends beyond an end stop, or in a pose that does not close. */
static bool within_stroke(const plant_parameters *p, const motion *now, double residual) {
  if (!(residual < 1e-3)) {
    return false;
  }
  for (int i = 0; i < N; ++i) {
    if (!(fabs(now->of.theta[i]) <= p->stroke)) {
      return false;
    }
  }
  return true;
}

static void tick(const plant_parameters *p, const plant_inputs *u, void *memory, plant_outputs *y) {
  state *s = (state *)memory;
  const int substeps = (int)p->substeps;
  const double h = p->Ts / substeps;
  double command[N];
  drive(p, u, s, command);
  y->end_stop = y->fault = 0.0;
  double disturbance[N];
  plant_hidden_torque(p, &s->hidden, s->ticks * p->Ts, s->now.of.theta, s->tau_motor, disturbance);
  for (int k = 0; k < substeps; ++k) {
    const motion before = s->now;
    double tau[3][N], d[N_D] = {0.0}, residual;
    plant_drive(s->tau_motor, command, &p->f_current, &h, tau[0], tau[1], tau[2]);
    memcpy(s->tau_motor, tau[2], sizeof s->tau_motor);
#ifdef PLANT_N_EFFECT
    plant_transmit(&s->effects, command, p->f_current, s->ticks * p->Ts + k * h, h, tau);
#endif
    for (int i = 0; i < 3 * N; ++i) {
      tau[i / N][i % N] -= disturbance[i % N];
    }
    integrate(p, s, tau, u->payload, h);
    if (diverged(&before, &s->now)) {
      s->now = before;
      memset(s->now.of.thetad, 0, sizeof s->now.of.thetad);
      y->fault = FAULT_DIVERGED;
      continue;
    }
    plant_close(s->now.of.theta, s->now.of.d, d, &residual);
    if (within_stroke(p, &s->now, residual)) {
      memcpy(s->now.of.d, d, sizeof d);
    } else {
      /* blocked: the mechanism stands where it was and may leave at the next substep */
      s->now = before;
      memset(s->now.of.thetad, 0, sizeof s->now.of.thetad);
      y->end_stop = 1.0;
      y->fault = FAULT_END_STOP;
    }
  }
  s->ticks += 1.0;
  read_sensors(p, s, y);
}

FLEXHEX_ROOM(plant, state, start, tick)
