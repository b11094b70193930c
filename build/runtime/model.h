/* The generated table that drives the adapter: which variables an FMU has, and which step.c. */
#ifndef FLEXHEX_MODEL_H
#define FLEXHEX_MODEL_H

#include "block.h"

typedef enum { FLEXHEX_FIXED, FLEXHEX_TUNABLE, FLEXHEX_INPUT, FLEXHEX_OUTPUT } flexhex_kind;

/* as FMI's functions see a variable; an enumeration is an Integer, and kept is a double of all */
typedef enum { FLEXHEX_REAL, FLEXHEX_INTEGER, FLEXHEX_BOOLEAN } flexhex_type;

typedef struct {
  const char *name;
  const char *const *elements; /* what follows the name in those of its elements; NULL: [1], ... */
  int size;                    /* 0: scalar, else an array of that many */
  flexhex_type type;
  flexhex_kind kind;
  double min, max;     /* of every element; -DBL_MAX, DBL_MAX: not bounded */
  const double *least; /* of each element in the place of min; NULL: min */
  const char *unit;
} flexhex_variable;

typedef struct {
  const char *identifier, *guid;
  double base_step; /* s */
  /* in value-reference order: parameters (first of all Ts), inputs, outputs (last of all fault) */
  const flexhex_variable *variables;
  int n_variables;
  const double *starts; /* one per value reference */
  int n_values;
  const flexhex_block *block;
  const char *const *faults; /* names of the values of fault, from 0 on */
  int n_faults;
} flexhex_model;

#define FLEXHEX_PASTE(a, b) a##b
#define FLEXHEX_JOIN(a, b) FLEXHEX_PASTE(a, b)

#ifdef FLEXHEX_IDENTIFIER
#define FLEXHEX_MODEL FLEXHEX_JOIN(FLEXHEX_IDENTIFIER, _fmu)
extern const flexhex_model FLEXHEX_MODEL;
#endif

#endif
