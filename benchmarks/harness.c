/* Timing loops in C: Python only chooses what runs next, so its calls cost nothing here.
   Each function runs its work `count` times and returns nanoseconds for one: the thread's own
   processor time, which on an idle machine is the time of the clock, and which other programs on
   the same core do not lengthen. */
#define _POSIX_C_SOURCE 200809L

#include <stddef.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"
#include "block.h"

static double now_ns(void) {
  struct timespec t;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* One instance of a block; rows of inputs are taken in turn. */
typedef struct {
  const flexhex_block *block;
  const void *p;
  const double *u; /* (rows, inputs of the block) */
  void *s, *y;
  long rows, at;
} instance;

static void tick(instance *i) {
  const size_t width = i->block->inputs / sizeof(double);
  i->block->tick(i->p, i->u + (size_t)i->at * width, i->s, i->y);
  i->at = (i->at + 1) % i->rows;
}

double bench_ticks(instance *i, long count) {
  const double begin = now_ns();
  for (long k = 0; k < count; ++k) {
    tick(i);
  }
  return (now_ns() - begin) / (double)count;
}

/* N_F, N_E and F; F takes the first `shared` outputs of N_F as its first inputs. */
double bench_chain(instance *N_F, instance *N_E, instance *F, double *u_F, long shared,
                   long count) {
  const double begin = now_ns();
  for (long k = 0; k < count; ++k) {
    tick(N_F);
    tick(N_E);
    memcpy(u_F, N_F->y, (size_t)shared * sizeof *u_F);
    tick(F);
  }
  return (now_ns() - begin) / (double)count;
}

/* A base step of an importer: set, step, get `n` values. */
typedef struct {
  fmi2SetRealTYPE *set;
  fmi2DoStepTYPE *step;
  fmi2GetRealTYPE *get;
  fmi2Component c;
  const fmi2ValueReference *inputs, *outputs;
  size_t n;
  double *values; /* (2, n): what is set, what was got */
  double base;
  long done;
} slave;

double bench_slave(slave *f, long count) {
  int bad = 0;
  const double begin = now_ns();
  for (long k = 0; k < count; ++k) {
    bad |= f->set(f->c, f->inputs, f->n, f->values) != fmi2OK;
    bad |= f->step(f->c, (double)f->done * f->base, f->base, fmi2True) != fmi2OK;
    bad |= f->get(f->c, f->outputs, f->n, f->values + f->n) != fmi2OK;
    f->done++;
  }
  const double spent = (now_ns() - begin) / (double)count;
  return bad ? -1.0 : spent;
}

/* A function of another library that takes two pointers, such as MuJoCo's mj_inverse(m, d). */
double bench_two_pointers(void (*call)(const void *, void *), const void *a, void *b, long count) {
  const double begin = now_ns();
  for (long k = 0; k < count; ++k) {
    call(a, b);
  }
  return (now_ns() - begin) / (double)count;
}
