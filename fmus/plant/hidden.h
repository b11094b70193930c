/* Hooks for the ground truth of machine.fmu; in plant.fmu they do nothing. */
#ifndef FLEXHEX_PLANT_HIDDEN_H
#define FLEXHEX_PLANT_HIDDEN_H

#if PLANT_HIDDEN
#include "truth.h"
#else

typedef struct {
  double none;
} plant_hidden_state;

static void plant_hidden_start(const plant_parameters *p, plant_hidden_state *s) {
  (void)p, (void)s;
}

static void plant_hidden_torque(const plant_parameters *p, plant_hidden_state *s, double t,
                                const double *theta, const double *tau_motor, double *torque) {
  (void)p, (void)s, (void)t, (void)theta, (void)tau_motor;
  for (int i = 0; i < PLANT_N; ++i) {
    torque[i] = 0.0;
  }
}

static double plant_hidden_reading(const plant_parameters *p, plant_hidden_state *s, double tau) {
  (void)p, (void)s;
  return tau;
}

#endif
#endif
