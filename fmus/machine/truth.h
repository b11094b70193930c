/* What machine.fmu has beyond the nominal plant: torques, noise and drift of its truth file. */
#ifndef FLEXHEX_MACHINE_TRUTH_H
#define FLEXHEX_MACHINE_TRUTH_H

#include <stdint.h>

#ifdef PLANT_N_HIDDEN
#include "hidden_effects.h"
#endif

typedef struct {
  uint64_t draw;
#ifdef PLANT_N_HIDDEN
  hidden_motion motion;
#endif
} plant_hidden_state;

/* Uniform in [0, 1) from the top 53 bits of SplitMix64 (Steele, Lea & Flood, OOPSLA 2014). */
static double hidden_uniform(plant_hidden_state *s) {
  uint64_t x = s->draw += UINT64_C(0x9e3779b97f4a7c15);
  x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
  return (double)((x ^ (x >> 31)) >> 11) / 9007199254740992.0; /* 2^53 */
}

/* Nearly normal, mean 0, variance 1: twelve uniforms, the same on every platform. */
static double hidden_noise(plant_hidden_state *s) {
  double sum = -6.0;
  for (int k = 0; k < 12; ++k) {
    sum += hidden_uniform(s);
  }
  return sum;
}

static void plant_hidden_start(const plant_parameters *p, plant_hidden_state *s) {
  s->draw = (uint64_t)p->seed;
#ifdef PLANT_N_HIDDEN
  hidden_motion_start(&s->motion);
#endif
}

/* Torque on the joints that the model lacks, t [s] after the start. */
static void plant_hidden_torque(const plant_parameters *p, plant_hidden_state *s, double t,
                                const double *theta, const double *tau_motor, double *torque) {
  const double age = p->age + t;
  plant_hidden(theta, tau_motor, &age, p->hidden_cogging, p->drift_torque, &p->drift_gain,
               &p->drift_time, torque);
  for (int i = 0; i < PLANT_N; ++i) {
    torque[i] += p->noise_torque * hidden_noise(s);
  }
#ifdef PLANT_N_HIDDEN
  hidden_effects(p, &s->motion, theta, tau_motor, torque);
#endif
}

static double plant_hidden_reading(const plant_parameters *p, plant_hidden_state *s, double tau) {
  return tau + p->noise_reading * hidden_noise(s);
}

#endif
