/* What the effects of the machine file do to the plant. Without effects all of this does nothing.

   Torques and losses of the drives are part of plant_rates. Here are what it wants to know of a
   substep, the drives that answer late, and what the encoders read. */
#ifndef FLEXHEX_PLANT_EFFECTS_H
#define FLEXHEX_PLANT_EFFECTS_H

#include <math.h>
#include <string.h>

#ifdef PLANT_N_EFFECT

/* motor: torque that the drives report, time: both at start, middle and end of a substep;
   taud: mean rate of that torque; lagged: where the lags of the drives are; late: past substeps */
typedef struct {
  double motor[3][PLANT_N], taud[PLANT_N], time[3];
  double lag[PLANT_N], delay[PLANT_N], lagged[PLANT_N];
  double late[PLANT_LINE][3][PLANT_N];
  double newest;
} plant_effects;

static void plant_effects_start(const plant_parameters *p, const double *theta, plant_effects *e,
                                double *state) {
  plant_effect_lines(p->effect, e->lag, e->delay);
  plant_effect_start(theta, state);
}

static bool plant_effects_refuse(const plant_effects *e, double h, char *message, size_t size) {
  for (int i = 0; i < PLANT_N; ++i) {
    if (!(e->lag[i] >= 0.0 && e->delay[i] >= 0.0 && e->delay[i] <= (PLANT_LINE - 2) * h)) {
      snprintf(message, size,
               "effect: axis %d has a lag of %.6g s and a delay of %.6g s,"
               " allowed from 0, the delay to %.6g s",
               i + 1, e->lag[i], e->delay[i], (PLANT_LINE - 2) * h);
      return true;
    }
  }
  return false;
}

/* The lag T x' = tau - x behind the current loop, both answered in closed form over a substep of h;
   the middle value is such that Simpson's rule gives the exact impulse, as in current_loop. */
static double plant_lag(double command, double rate, double T, double h, double tau[3], double x) {
  const double gap = tau[0] - command, decay = 1.0 / T, apart = (decay - rate) * h;
  const double shared = apart != 0.0 ? -expm1(-apart) / apart : 1.0;
  const double through = decay * h * exp(-rate * h) * shared;
  const double mean_tau = command - gap * expm1(-rate * h) / (rate * h);
  const double last = command + gap * through + (x - command) * exp(-decay * h);
  const double mean = mean_tau - T * (last - x) / h;
  tau[0] = x;
  tau[1] = (6 * mean - x - last) / 4;
  tau[2] = last;
  return last;
}

/* The torque of a substep as it was `delay` [s] before: between two whole numbers of substeps. */
static void plant_delay(const plant_effects *e, int i, double h, double tau[3][PLANT_N]) {
  const double steps = e->delay[i] / h, whole = floor(steps), share = steps - whole;
  const int newer = ((int)e->newest + PLANT_LINE - (int)whole) % PLANT_LINE;
  const int older = (newer + PLANT_LINE - 1) % PLANT_LINE;
  for (int k = 0; k < 3; ++k) {
    tau[k][i] = (1.0 - share) * e->late[newer][k][i] + share * e->late[older][k][i];
  }
}

/* From the torque that the drives report, tau at start, middle and end of the substep of h at
   `time`, to what leaves them. rate [1/s]: of the current loop. */
static void plant_transmit(plant_effects *e, const double *command, double rate, double time,
                           double h, double tau[3][PLANT_N]) {
  memcpy(e->motor, tau, sizeof e->motor);
  for (int k = 0; k < 3; ++k) {
    e->time[k] = time + k * h / 2;
  }
  for (int i = 0; i < PLANT_N; ++i) {
    e->taud[i] = (tau[2][i] - tau[0][i]) / h;
    if (e->lag[i] > 0.0) {
      double own[3] = {tau[0][i], tau[1][i], tau[2][i]};
      e->lagged[i] = plant_lag(command[i], rate, e->lag[i], h, own, e->lagged[i]);
      tau[0][i] = own[0], tau[1][i] = own[1], tau[2][i] = own[2];
    }
  }
  e->newest = fmod(e->newest + 1.0, PLANT_LINE);
  memcpy(e->late[(int)e->newest], tau, sizeof e->late[0]);
  for (int i = 0; i < PLANT_N; ++i) {
    plant_delay(e, i, h, tau);
  }
}

#endif
#endif
