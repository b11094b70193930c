/* Two doubles that are computed side by side, in one instruction where the compiler has vectors.
   Each is rounded as it would be alone, so the results are the same to the last bit. */
#ifndef FLEXHEX_PAIR_H
#define FLEXHEX_PAIR_H

#include <math.h>

#if defined(__GNUC__) && !defined(__TINYC__) && !defined(FLEXHEX_NO_VECTORS)
typedef double pair __attribute__((vector_size(16)));
#define FIRST(x) ((x)[0])
#define SECOND(x) ((x)[1])
#define ADD(x, y) ((x) + (y))
#define SUB(x, y) ((x) - (y))
#define MUL(x, y) ((x) * (y))
#define DIV(x, y) ((x) / (y))
#define NEG(x) (-(x))
#else
typedef struct {
  double first, second;
} pair;
#define FIRST(x) ((x).first)
#define SECOND(x) ((x).second)
static inline pair both(double first, double second) {
  pair result = {first, second};
  return result;
}
#define ADD(x, y) both((x).first + (y).first, (x).second + (y).second)
#define SUB(x, y) both((x).first - (y).first, (x).second - (y).second)
#define MUL(x, y) both((x).first *(y).first, (x).second *(y).second)
#define DIV(x, y) both((x).first / (y).first, (x).second / (y).second)
#define NEG(x) both(-(x).first, -(x).second)
#endif
#define SQUARE(x) MUL(x, x)
#define TWICE(x) ADD(x, x)

#define SIGN(x) ((x) < 0.0 ? -1.0 : (x) > 0.0 ? 1.0 : (x))

#endif
