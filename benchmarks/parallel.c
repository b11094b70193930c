/* Work that shares nothing with any other: what one core and two give by themselves. Each function
   does n rounds and returns a number that depends on all of them, so that none is left out. */

#define TWO(x) x x
#define SIXTEEN(x) TWO(TWO(TWO(TWO(x))))
/* four sums that do not wait for one another; they stay near 2 */
#define FOUR(x)     \
  a = a * half + x; \
  b = b * half + x; \
  c = c * half + x; \
  d = d * half + x;

enum { VALUES = 2048 }; /* 16 KiB, half of a small nearest cache */

double parallel_registers(long n);
double parallel_values(long n);
double parallel_code(long n);

double parallel_registers(long n) {
  const double half = 0.5;
  double a = 1.0, b = 2.0, c = 3.0, d = 4.0;
  long i;
  for (i = 0; i < n; i++) {
    SIXTEEN(FOUR(1.0))
  }
  return a + b + c + d;
}

double parallel_values(long n) {
  double values[VALUES], sum = 0.0;
  long i, k;
  for (k = 0; k < VALUES; k++) {
    values[k] = (double)k;
  }
  for (i = 0; i < n; i++) {
    for (k = 0; k < VALUES; k++) {
      values[k] = 0.5 * values[VALUES - 1 - k] + 1.0;
    }
    sum += values[i % VALUES];
  }
  return sum;
}

/* 2048 times four sums: more code than a nearest cache of instructions holds */
double parallel_code(long n) {
  const double half = 0.5;
  double a = 1.0, b = 2.0, c = 3.0, d = 4.0;
  long i;
  for (i = 0; i < n; i++) {
    SIXTEEN(SIXTEEN(TWO(TWO(TWO(FOUR(1.0))))))
  }
  return a + b + c + d;
}
