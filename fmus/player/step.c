/* Player of a table: the two rows around an instant, and the motion between them.

   Times are a count of ticks. As in the reference, the tick at k Ts computes what is due when its
   results appear, at (k + 1) Ts. */
#include "player.h"

#include "player_table.h"

#include <math.h>
#include <string.h>

typedef struct {
  double ticks;
} state;

/* Index of the last row at or before t, never the last of all. */
static int row_before(double t) {
  int low = 0, high = ROWS - 1;
  while (high - low > 1) {
    const int middle = low + (high - low) / 2;
    if (row_time[middle] <= t) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return low;
}

/* All outputs at a tick counted from the start of the simulation. */
static void at_tick(const player_parameters *p, double tick, player_outputs *y) {
  const double since = (tick - nearbyint(p->t_start / p->Ts)) * p->Ts;
  const double t = fmin(fmax(since, 0.0), row_time[ROWS - 1]);
  const int k = row_before(t);
  const double in_row = t - row_time[k], apart = row_time[k + 1] - row_time[k];
  double motion[PLAYER_N_MOTION];
  player_between(&in_row, &apart, row[k], row[k + 1], motion);
  /* the outputs begin with values, rates and accelerations, in the order of a row */
  memcpy(y, motion, sizeof motion);
  y->payload = t < row_time[ROWS - 1] ? row_payload[k] : row_payload[ROWS - 1];
}

static bool start(const player_parameters *p, void *memory, player_outputs *y, char *message,
                  size_t size) {
  state *s = (state *)memory;
  const double steps = p->t_start / p->Ts;
  if (fabs(steps - nearbyint(steps)) > 1e-6) {
    snprintf(message, size, "t_start = %.9g s, must be a whole number of Ts = %.9g s", p->t_start,
             p->Ts);
    return false;
  }
  memset(s, 0, sizeof *s);
  memset(y, 0, sizeof *y);
  at_tick(p, 0.0, y);
  return true;
}

static void tick(const player_parameters *p, const player_inputs *u, void *memory,
                 player_outputs *y) {
  state *s = (state *)memory;
  (void)u;
  s->ticks += 1.0;
  at_tick(p, s->ticks + 1.0, y);
}

FLEXHEX_BLOCK(player, state, start, tick)
