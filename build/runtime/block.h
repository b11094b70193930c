/* Interface from an FMU's step.c to the FMI adapter: sizes, a start and a tick; no FMI in it. */
#ifndef FLEXHEX_BLOCK_H
#define FLEXHEX_BLOCK_H

#include <float.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#ifdef __cplusplus
#define restrict __restrict /* C++ has it under this name only */
#define FLEXHEX_C extern "C"
#else
#define FLEXHEX_C
#endif

typedef struct {
  /* bytes of the structs of step.c; the first three are plain arrays of double */
  size_t parameters, inputs, outputs, state;

  /* Check the parameters p, fill the state s and the initial outputs y (both come in zeroed).
     On a wrong parameter: one line into message[size], return false. */
  bool (*start)(const void *p, void *s, void *y, char *message, size_t size);

  /* One sample time: read u, write y, which holds the previous outputs on entry. Never fails;
     trouble goes to y->fault (2 and up) and flags. Allocates, locks and prints nothing. */
  void (*tick)(const void *p, const void *u, void *s, void *y);
} flexhex_block;

/* Defines `const flexhex_block <name>_block`, the only symbol that a step.c exports. The thunks
   turn the adapter's untyped pointers into the generated structs: calling step.c's functions
   through cast function pointers would be undefined. */
#define FLEXHEX_BLOCK(name, state_type, start_function, tick_function)                             \
  static bool name##_start_thunk(const void *p, void *s, void *y, char *message, size_t size) {    \
    return start_function((const name##_parameters *)p, s, (name##_outputs *)y, message, size);    \
  }                                                                                                \
  static void name##_tick_thunk(const void *p, const void *u, void *s, void *y) {                  \
    tick_function((const name##_parameters *)p, (const name##_inputs *)u, s, (name##_outputs *)y); \
  }                                                                                                \
  extern const flexhex_block name##_block;                                                         \
  const flexhex_block name##_block = {                                                             \
      sizeof(name##_parameters), sizeof(name##_inputs), sizeof(name##_outputs),                    \
      sizeof(state_type),        name##_start_thunk,    name##_tick_thunk,                         \
  };

#endif
