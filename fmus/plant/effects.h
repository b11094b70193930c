/* What the effects of the machine file do to the plant. Without effects all of this does nothing.

   Torques and losses of the drives are part of plant_rates. Here are its further inputs in a
   substep, lag and delay of the drives, and the encoder readings. */
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
  double late[PLANT_LINE][4][PLANT_N];
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

/* The torque of a substep as it was `delay` [s] before: between two whole numbers of substeps. */
static void plant_delay(const plant_effects *e, int i, double h, double tau[4][PLANT_N]) {
  const double steps = e->delay[i] / h, whole = floor(steps), share = steps - whole;
  const int newer = ((int)e->newest + PLANT_LINE - (int)whole) % PLANT_LINE;
  const int older = (newer + PLANT_LINE - 1) % PLANT_LINE;
  for (int k = 0; k < 4; ++k) {
    tau[k][i] = (1.0 - share) * e->late[newer][k][i] + share * e->late[older][k][i];
  }
}

/* From the torque that the drives report, tau as in `action` for the substep of h at `time`, to the
   torque at their output. f_current [Hz]: of the current loop. */
static void plant_transmit(plant_effects *e, const double *command, double f_current, double time,
                           double h, double tau[4][PLANT_N]) {
  memcpy(e->motor, tau, sizeof e->motor);
  for (int k = 0; k < 3; ++k) {
    e->time[k] = time + k * h / 2;
  }
  for (int i = 0; i < PLANT_N; ++i) {
    e->taud[i] = (tau[2][i] - tau[0][i]) / h;
    if (e->lag[i] > 0.0) {
      double own[3];
      plant_effect_lag(&tau[0][i], &command[i], &f_current, &e->lag[i], &h, &e->lagged[i], &own[0],
                       &own[1], &own[2]);
      tau[0][i] = own[0], tau[1][i] = own[1], tau[2][i] = own[2];
      tau[3][i] = (own[0] + 2.0 * own[1]) / 6.0; /* by Simpson's rule */
      e->lagged[i] = own[2];
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
