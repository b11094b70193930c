/* A shared library that never finishes loading, for tests of faults. */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <unistd.h>

__attribute__((constructor)) static void hang(void) {
  (void)fputs("hangs\n", stderr);
  for (;;) {
    (void)pause();
  }
}
