/* Reference: which motion acts at which tick; setpoints and phases from a counted generator.

   Every time is a whole number of ticks, nothing is accumulated. The tick at k Ts computes what is
   due when its results appear, at (k + 1) Ts. Each pass begins and ends at rest at zero. */
#include "reference.h"

#include "splitmix64.h"

#include <math.h>
#include <string.h>

enum { N = REFERENCE_N, N_PHASES = REFERENCE_N * REFERENCE_MAX_SINES };
enum { RANDOM, TRIANGLE, MULTISINE, CHIRP, HOLD };
static const double TWO_PI = 6.283185307179586;

typedef struct {
  double ticks;
  double phase[N_PHASES];
  double cycles[N];
} state;

static double ticks_of(const reference_parameters *p, double time) {
  return nearbyint(time / p->Ts);
}

/* Setpoint `k` of a pass; before the first and at the last it is zero. */
static void setpoint(const reference_parameters *p, double k, double *r) {
  const double last = nearbyint(p->duration / p->period) - 1.0;
  for (int i = 0; i < N; ++i) {
    const double u = k < 0.0 || k >= last ? 0.5 : uniform(p->seed, k * N + i);
    r[i] = p->amplitude[i] * (2.0 * u - 1.0);
  }
}

static void random_setpoints(const reference_parameters *p, double tick, reference_outputs *y) {
  const double period = ticks_of(p, p->period), k = floor(tick / period);
  const double t = (tick - k * period) * p->Ts;
  double r_from[N], r_to[N];
  setpoint(p, k, r_to);
  if (t >= p->move) {
    memcpy(y->r, r_to, sizeof y->r);
    return;
  }
  setpoint(p, k - 1.0, r_from);
  reference_random(&t, &p->move, r_from, r_to, y->r, y->rd, y->rdd);
}

/* Motion at a tick counted from the begin of the pass. */
static void motion(const reference_parameters *p, const state *s, double tick,
                   reference_outputs *y) {
  const double t = tick * p->Ts, *T = &p->duration;
  switch ((int)p->kind) {
    case RANDOM:
      random_setpoints(p, tick, y);
      break;
    case TRIANGLE:
      reference_triangle(&t, s->cycles, p->amplitude, &p->speed, &p->rounding, y->r, y->rd, y->rdd);
      break;
    case MULTISINE:
      reference_multisine(&t, T, &p->fade, &p->f_base, &p->n_sines, s->phase, p->amplitude, y->r,
                          y->rd, y->rdd);
      break;
    case CHIRP:
      reference_chirp(&t, T, &p->fade, &p->f0, &p->f1, p->amplitude, y->r, y->rd, y->rdd);
      break;
    default:
      break;
  }
}

/* All outputs at a tick counted from the start of the simulation. */
static void at_tick(const reference_parameters *p, const state *s, double tick,
                    reference_outputs *y) {
  const double since = tick - ticks_of(p, p->t_start), pass = ticks_of(p, p->duration);
  memset(y, 0, sizeof *y);
  if (since >= 0.0 && since < p->passes * pass) {
    motion(p, s, fmod(since, pass), y);
  }
  for (int k = 0; k < (int)p->payload_count; ++k) {
    if (tick >= ticks_of(p, p->payload_time[k])) {
      y->payload = p->payload_mass[k];
    }
  }
}

static bool whole(const char *name, double value, char *message, size_t size) {
  if (value == floor(value)) {
    return true;
  }
  snprintf(message, size, "%s = %.17g, must be a whole number", name, value);
  return false;
}

/* `time` must be a whole number of steps of `unit`, whose name is `what`. */
static bool divides(const char *name, double time, const char *what, double unit, char *message,
                    size_t size) {
  const double steps = time / unit;
  if (fabs(steps - nearbyint(steps)) <= 1e-6) {
    return true;
  }
  snprintf(message, size, "%s = %.9g s, must be a whole number of %s = %.9g s", name, time, what,
           unit);
  return false;
}

static bool check_times(const reference_parameters *p, char *message, size_t size) {
  if (!divides("t_start", p->t_start, "Ts", p->Ts, message, size) ||
      !divides("duration", p->duration, "Ts", p->Ts, message, size)) {
    return false;
  }
  for (int k = 1; k < (int)p->payload_count; ++k) {
    if (p->payload_time[k] <= p->payload_time[k - 1]) {
      snprintf(message, size, "payload_time[%d] = %.9g s, must be later than the %.9g s before it",
               k + 1, p->payload_time[k], p->payload_time[k - 1]);
      return false;
    }
  }
  return true;
}

static bool check_random(const reference_parameters *p, char *message, size_t size) {
  if (!divides("period", p->period, "Ts", p->Ts, message, size) ||
      !divides("duration", p->duration, "period", p->period, message, size)) {
    return false;
  }
  if (p->move > p->period) {
    snprintf(message, size, "move = %.9g s, longer than period = %.9g s: shorten the move", p->move,
             p->period);
    return false;
  }
  return true;
}

static bool check_triangle(const reference_parameters *p, const state *s, char *message,
                           size_t size) {
  const double least = p->speed * p->speed / p->rounding;
  for (int i = 0; i < N; ++i) {
    if (p->amplitude[i] > 0.0 && p->amplitude[i] < least) {
      snprintf(message, size,
               "amplitude[%d] = %.9g rad, the corners of the triangle need speed^2 / rounding"
               " = %.9g rad: lower the speed",
               i + 1, p->amplitude[i], least);
      return false;
    }
    if (p->amplitude[i] > 0.0 && s->cycles[i] < 1.0) {
      snprintf(message, size,
               "duration = %.9g s, too short for one cycle of the triangle of joint %d: "
               "raise duration or speed",
               p->duration, i + 1);
      return false;
    }
  }
  return true;
}

static bool check_kind(const reference_parameters *p, const state *s, char *message, size_t size) {
  switch ((int)p->kind) {
    case RANDOM:
      return check_random(p, message, size);
    case TRIANGLE:
      return check_triangle(p, s, message, size);
    case MULTISINE:
    case CHIRP:
      if (2.0 * p->fade <= p->duration) {
        return true;
      }
      snprintf(message, size, "fade = %.9g s, longer than half of duration = %.9g s", p->fade,
               p->duration);
      return false;
    default:
      return true;
  }
}

static bool start(const reference_parameters *p, void *memory, reference_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
  memset(s, 0, sizeof *s);
  if (!whole("kind", p->kind, message, size) || !whole("seed", p->seed, message, size) ||
      !whole("passes", p->passes, message, size) || !whole("n_sines", p->n_sines, message, size) ||
      !whole("payload_count", p->payload_count, message, size)) {
    return false;
  }
  reference_cycles(&p->duration, p->amplitude, &p->speed, &p->rounding, s->cycles);
  for (int k = 0; k < N_PHASES; ++k) {
    s->phase[k] = TWO_PI * uniform(p->seed, k);
  }
  if (!check_times(p, message, size) || !check_kind(p, s, message, size)) {
    return false;
  }
  at_tick(p, s, 0.0, y);
  return true;
}

static void tick(const reference_parameters *p, const reference_inputs *u, void *memory,
                 reference_outputs *y) {
  state *s = (state *)memory;
  (void)u;
  s->ticks += 1.0;
  at_tick(p, s, s->ticks + 1.0, y);
}

FLEXHEX_BLOCK(reference, state, start, tick)
