/* Measurement filter: one Hann window over angles, torques and actuator basis, all of one instant.

   A ring keeps the raw samples; every output is a plain sum over a window of them, so nothing can
   drift. The derivatives belong to the middle of three windows, one sample back; torque and basis
   are windowed that much earlier, and `alignment` samples more. */
#include "filter.h"

#include "effects.h"
#include "wide.h"

#include <math.h>
#include <string.h>

enum {
  N = FILTER_N,
  N_CHI = FILTER_N_CHI,
  POINTS = FILTER_POINTS,
  STENCIL = 1,
  LENGTH = POINTS + STENCIL + FILTER_MAX_ALIGNMENT
};

/* one instant: theta, tau, columns of the effects, chi; an array, so that a window is one loop */
enum { AT_TAU = N, AT_EFFECT = 2 * N, AT_CHI = AT_EFFECT + N_EFFECT, N_SAMPLE = AT_CHI + N_CHI };

typedef struct {
  double taps[POINTS];
  double ring[LENGTH][N_SAMPLE];
  double newest;
  double theta_f[3][N];
  double theta_last[N], z[N];
  double started;
#ifdef FILTER_N_EFFECT
  filter_effects effects;
#endif
} state;

/* Weighted sum of the first `count` values of the samples in the window that ends `age` samples
   before the newest. Four samples at a time spare most of the sums' way to memory and back. */
static INLINE void sums(const state *s, int age, int count, double *restrict sum) {
  const double *sample[POINTS + 3];
  double tap[POINTS + 3] = {0.0};
  int at = ((int)s->newest + LENGTH - age) % LENGTH;
  for (int n = 0; n < POINTS; ++n) {
    sample[n] = s->ring[at];
    tap[n] = s->taps[n];
    at = at == 0 ? LENGTH - 1 : at - 1;
  }
  sample[POINTS] = sample[POINTS + 1] = sample[POINTS + 2] = s->ring[at];
  memset(sum, 0, (size_t)count * sizeof *sum);
  for (int n = 0; n < POINTS; n += 4) {
    const double *a = sample[n], *b = sample[n + 1], *c = sample[n + 2], *d = sample[n + 3];
    const double w_a = tap[n], w_b = tap[n + 1], w_c = tap[n + 2], w_d = tap[n + 3];
    for (int k = 0; k < count; ++k) {
      sum[k] += (w_a * a[k] + w_b * b[k]) + (w_c * c[k] + w_d * d[k]);
    }
  }
}

/* The same in as many doubles at once as the processor has: same bits. */
static void sums_in_pairs(const state *s, int age, int count, double *sum) {
  sums(s, age, count, sum);
}

#ifdef QUADS
static QUADS void sums_in_quads(const state *s, int age, int count, double *sum) {
  sums(s, age, count, sum);
}
#endif

/* The faster of the two on this processor, for all instances. */
static void (*window)(const state *s, int age, int count, double *sum) = sums_in_pairs;

static bool start(const filter_parameters *p, void *memory, filter_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
#ifdef QUADS
  window = quads_there() ? sums_in_quads : sums_in_pairs;
#endif
  if (p->alignment != floor(p->alignment)) {
    snprintf(message, size, "alignment = %.17g, must be a whole number", p->alignment);
    return false;
  }
  if (p->basis != 0.0 && p->basis != 1.0) {
    snprintf(message, size, "basis = %.17g, must be 0 or 1", p->basis);
    return false;
  }
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  filter_taps(s->taps);
  filter_basis(s->theta_last, s->z, y->chi_f);
#ifdef FILTER_N_EFFECT
  filter_instant rest;
  memset(&rest, 0, sizeof rest);
  filter_effect_start(rest.of.theta, s->effects.state);
  filter_effect_columns(rest.all, s->effects.state, y->chi_f + N_CHI);
#endif
  return true;
}

/* Dahl states follow the angle alone, through a backlash that removes its noise; at the first
   sample there is no earlier angle. */
static void follow(const filter_parameters *p, state *s, const double *theta) {
  double moved[N], z_next[N];
  if (s->started == 0.0) {
    memcpy(s->theta_last, theta, sizeof s->theta_last);
    return;
  }
  for (int i = 0; i < N; ++i) {
    moved[i] = fmin(fmax(s->theta_last[i], theta[i] - p->play), theta[i] + p->play);
  }
  filter_dahl(s->z, s->theta_last, moved, z_next);
  memcpy(s->z, z_next, sizeof s->z);
  memcpy(s->theta_last, moved, sizeof s->theta_last);
}

/* Put a raw sample into the ring; the first one fills it, as if it had always been so. */
static void keep(state *s, const double *now) {
  const int newest = ((int)s->newest + 1) % LENGTH;
  const int copies = s->started == 0.0 ? LENGTH : 1;
  for (int k = 0; k < copies; ++k) {
    memcpy(s->ring[(newest + k) % LENGTH], now, sizeof s->ring[0]);
  }
  s->newest = newest;
}

/* The columns of an effect need the rates at their instant, so they are computed one sample later;
   the first ones fill the ring. */
static void note_effects(const filter_parameters *p, state *s) {
#ifdef FILTER_N_EFFECT
  const int newest = (int)s->newest, middle = (newest + LENGTH - 1) % LENGTH;
  const double *past = s->ring[(newest + LENGTH - 2) % LENGTH];
  double columns[N_EFFECT];
  filter_effects_at(&s->effects, p->Ts, past, s->ring[middle], s->ring[newest], columns);
  const int copies = s->started == 0.0 ? LENGTH : 1;
  for (int k = 0; k < copies; ++k) {
    memcpy(s->ring[(middle + k) % LENGTH] + AT_EFFECT, columns, sizeof columns);
  }
#else
  (void)p, (void)s;
#endif
}

static void differentiate(const filter_parameters *p, state *s, filter_outputs *y) {
  memmove(s->theta_f + 1, s->theta_f, 2 * sizeof s->theta_f[0]);
  window(s, 0, N, s->theta_f[0]);
  if (s->started == 0.0) {
    memcpy(s->theta_f[1], s->theta_f[0], sizeof s->theta_f[0]);
    memcpy(s->theta_f[2], s->theta_f[0], sizeof s->theta_f[0]);
  }
  memcpy(y->theta_f, s->theta_f[1], sizeof y->theta_f);
  filter_derivatives(s->theta_f[2], s->theta_f[1], s->theta_f[0], &p->Ts, y->theta_fd,
                     y->theta_fdd);
}

static void tick(const filter_parameters *p, const filter_inputs *u, void *memory,
                 filter_outputs *y) {
  state *s = (state *)memory;
  const int age = STENCIL + (int)p->alignment;
  const bool filtered_basis = p->basis != 0.0;
  double now[N_SAMPLE] = {0.0}, past[N_SAMPLE];
  memcpy(now, u->theta, sizeof u->theta);
  memcpy(now + AT_TAU, u->tau_meas, sizeof u->tau_meas);
  if (filtered_basis) {
    follow(p, s, now);
    filter_basis(now, s->z, now + AT_CHI);
  }
  keep(s, now);
  note_effects(p, s);
  differentiate(p, s, y);
  window(s, age, filtered_basis ? N_SAMPLE : AT_CHI, past);
  if (!filtered_basis) {
    follow(p, s, past);
    filter_basis(past, s->z, past + AT_CHI);
  }
  memcpy(y->tau_f, past + AT_TAU, sizeof y->tau_f);
  memcpy(y->chi_f, past + AT_CHI, N_CHI * sizeof past[0]);
#ifdef FILTER_N_EFFECT
  memcpy(y->chi_f + N_CHI, past + AT_EFFECT, N_EFFECT * sizeof past[0]);
#endif
  s->started = 1.0;
}

FLEXHEX_BLOCK(filter, state, start, tick)
