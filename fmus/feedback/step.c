/* Feedback: six PIDs on the delayed reference, plus the feedforward, within the drive's limits. */
#include "feedback.h"

#include <math.h>
#include <string.h>

/* newest sample, the longest delay, two more for the interpolation */
enum { N = FEEDBACK_N, NODES = 4, LENGTH = FEEDBACK_MAX_DELAY + 3 };
static const double FAULT_SATURATED = 2.0, FAULT_FOLLOWING = 3.0;

typedef struct {
  double ring[LENGTH][N];
  double newest;
  double youngest; /* age of the first interpolation node */
  double weights[NODES];
  double e_last[N], e_I[N], e_D[N];
  double carried[N];
  double started;
} state;

static bool start(const feedback_parameters *p, void *memory, feedback_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
  if (p->tau_step > p->tau_max) {
    snprintf(message, size, "tau_step = %.9g N m, more than tau_max = %.9g N m", p->tau_step,
             p->tau_max);
    return false;
  }
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  /* the delay lies between the second and the third node wherever there is a younger one */
  s->youngest = fmax(floor(p->reference_delay) - 1.0, 0.0);
  const double mu = p->reference_delay - s->youngest;
  feedback_lagrange(&mu, s->weights);
  return true;
}

/* Keep the newest reference and give the delayed one; the first has always been so. */
static void delayed(state *s, const double *r, double *r_delayed) {
  const int newest = ((int)s->newest + 1) % LENGTH;
  const int copies = s->started == 0.0 ? LENGTH : 1;
  for (int k = 0; k < copies; ++k) {
    memcpy(s->ring[(newest + k) % LENGTH], r, sizeof s->ring[0]);
  }
  s->newest = newest;
  memset(r_delayed, 0, N * sizeof *r_delayed);
  for (int k = 0; k < NODES; ++k) {
    const double *sample = s->ring[(newest + LENGTH - (int)s->youngest - k) % LENGTH];
    for (int i = 0; i < N; ++i) {
      r_delayed[i] += s->weights[k] * sample[i];
    }
  }
}

static double clipped(double value, double limit) {
  return fmax(-limit, fmin(limit, value));
}

/* Torque command for a wanted torque: whole current steps within the limit; the remainder is
   added to the next command. The limit itself is taken down to whole steps: what lies beyond
   is never given, so it is not owed either, and the rest stays within half a step. */
static double command(const feedback_parameters *p, double wanted, double *carried) {
  /* a quotient of decimal fractions may fall short of a whole number by rounding */
  const double steps =
      p->tau_step > 0.0 ? floor(p->tau_max / p->tau_step * (1.0 + 1e-12)) : INFINITY;
  if (isinf(steps)) { /* no steps, or too fine to count */
    return clipped(wanted, p->tau_max);
  }
  const double most = fmin(p->tau_max, p->tau_step * steps);
  const double owed = clipped(wanted, most) + *carried;
  const double given = clipped(p->tau_step * nearbyint(owed / p->tau_step), most);
  *carried = owed - given;
  return given;
}

static void tick(const feedback_parameters *p, const feedback_inputs *u, void *memory,
                 feedback_outputs *y) {
  state *s = (state *)memory;
  double r[N], e_I[N];
  delayed(s, u->r, r);
  for (int i = 0; i < N; ++i) {
    y->e[i] = r[i] - u->theta[i];
  }
  if (s->started == 0.0) {
    /* no step of the torque, no kick of the derivative, whatever the first error */
    memcpy(s->e_last, y->e, sizeof s->e_last);
    feedback_bumpless(y->e, &p->t_i, s->e_I);
    memcpy(e_I, s->e_I, sizeof e_I);
    s->started = 1.0;
  } else {
    feedback_follow(y->e, s->e_last, s->e_I, s->e_D, &p->t_f, &p->Ts, e_I, s->e_D);
    memcpy(s->e_last, y->e, sizeof s->e_last);
  }
  feedback_torque(y->e, e_I, s->e_D, p->kp, &p->t_i, &p->t_d, y->tau_fb);

  bool saturated = false, lost = false, clamped = false;
  for (int i = 0; i < N; ++i) {
    const double wanted = y->tau_fb[i] + p->ff_gain * u->tau_ff[i];
    const bool beyond = fabs(wanted) > p->tau_max;
    /* anti-windup: in the limit the integral may only lead out of it */
    if (beyond && (e_I[i] - s->e_I[i]) * wanted > 0.0) {
      e_I[i] = s->e_I[i];
      clamped = true;
    }
    saturated = saturated || beyond;
    lost = lost || fabs(y->e[i]) > p->e_max;
  }
  if (clamped) {
    feedback_torque(y->e, e_I, s->e_D, p->kp, &p->t_i, &p->t_d, y->tau_fb);
  }
  memcpy(s->e_I, e_I, sizeof s->e_I);
  for (int i = 0; i < N; ++i) {
    y->tau[i] = command(p, y->tau_fb[i] + p->ff_gain * u->tau_ff[i], &s->carried[i]);
  }
  y->fault = lost ? FAULT_FOLLOWING : saturated ? FAULT_SATURATED : 0.0;
}

FLEXHEX_BLOCK(feedback, state, start, tick)
