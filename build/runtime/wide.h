/* Four doubles side by side on an x86-64 that has AVX, which is asked when the program runs: for
   loops that are worth two forms. Each is rounded as it would be alone, so the results are the same
   to the last bit. gcc for Windows does not align its stack for them. */
#ifndef FLEXHEX_WIDE_H
#define FLEXHEX_WIDE_H

#include <stdbool.h>

#if defined(__GNUC__) && !defined(__TINYC__)
#define INLINE inline __attribute__((always_inline))
#else
#define INLINE inline
#endif

#if defined(__GNUC__) && defined(__x86_64__) && !defined(__TINYC__) && !defined(_WIN32) && \
    !defined(FLEXHEX_NO_VECTORS) && !defined(FLEXHEX_NO_QUADS)
#include <cpuid.h>

#define QUADS __attribute__((target("avx")))
typedef double quad __attribute__((vector_size(32)));

/* Elements of x (0 to 3) and y (4 to 7) in any order. */
#ifdef __has_builtin
#if __has_builtin(__builtin_shufflevector)
#define MIXED(x, y, a, b, c, d) __builtin_shufflevector(x, y, a, b, c, d)
#endif
#endif
#ifndef MIXED
#define ELEMENT(x, y, k) ((k) < 4 ? (x)[(k) & 3] : (y)[(k) & 3])
#define MIXED(x, y, a, b, c, d) \
  {ELEMENT(x, y, a), ELEMENT(x, y, b), ELEMENT(x, y, c), ELEMENT(x, y, d)}
#endif

/* Whether the processor has the instructions and the system keeps the registers. */
static inline bool quads_there(void) {
  const unsigned wanted = bit_OSXSAVE | bit_AVX;
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (!__get_cpuid(1, &a, &b, &c, &d) || (c & wanted) != wanted) {
    return false;
  }
  __asm__("xgetbv" : "=a"(a), "=d"(d) : "c"(0));
  return (a & 6U) == 6U;
}
#endif

#endif
