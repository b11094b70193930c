/* Random numbers that are the same on every platform. */
#ifndef FLEXHEX_SPLITMIX64_H
#define FLEXHEX_SPLITMIX64_H

#include <stdint.h>

/* Uniform double in [0, 1): number `index` (from 0) of the splitmix64 sequence of a seed.
   G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators", OOPSLA
   2014. The state is a counter, so any number is computed directly. */
static double uniform(double seed, double index) {
  uint64_t x = (uint64_t)seed + ((uint64_t)index + 1U) * UINT64_C(0x9e3779b97f4a7c15);
  x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
  x = x ^ (x >> 31);
  return (double)(x >> 11) / 9007199254740992.0; /* 2^53 */
}

#endif
