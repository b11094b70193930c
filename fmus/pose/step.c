/* Inverse kinematics: which arms reach the pose; the last angles where one does not. */
#include "pose.h"

#include <math.h>
#include <string.h>

static const double FAULT_UNREACHABLE = 2.0;

/* the last angles stand in the outputs, which stay until they are written */
typedef struct {
  double none;
} state;

static bool start(const pose_parameters *p, void *memory, pose_outputs *y, char *message,
                  size_t size) {
  (void)p, (void)message, (void)size;
  memset(memory, 0, sizeof(state));
  memset(y, 0, sizeof *y);
  for (int i = 0; i < POSE_N; ++i) {
    y->reachable[i] = 1.0;
  }
  return true;
}

static void tick(const pose_parameters *p, const pose_inputs *u, void *memory, pose_outputs *y) {
  double r[POSE_N], rd[POSE_N], rdd[POSE_N], margin[POSE_N];
  bool all = true;
  (void)memory;
  pose_solve(u->x_E, u->lam_E, u->xd_E, u->lamd_E, u->xdd_E, u->lamdd_E, r, rd, rdd, margin);
  for (int i = 0; i < POSE_N; ++i) {
    /* each comparison is false for NaN */
    const bool reached =
        margin[i] >= p->margin && fabs(r[i]) <= p->stroke && isfinite(rd[i]) && isfinite(rdd[i]);
    y->reachable[i] = reached ? 1.0 : 0.0;
    all = all && reached;
  }
  if (!all) {
    memset(y->rd, 0, sizeof y->rd);
    memset(y->rdd, 0, sizeof y->rdd);
    y->fault = FAULT_UNREACHABLE;
    return;
  }
  memcpy(y->r, r, sizeof r);
  memcpy(y->rd, rd, sizeof rd);
  memcpy(y->rdd, rdd, sizeof rdd);
  y->fault = 0.0;
}

FLEXHEX_BLOCK(pose, state, start, tick)
