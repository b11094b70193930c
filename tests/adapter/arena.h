/* Every allocation of the program, libc's own included, counted and taken from an arena.

   Include it once in a program, after ARENA, its size in bytes, is defined. */
#ifndef FLEXHEX_TEST_ARENA_H
#define FLEXHEX_TEST_ARENA_H

#include <stddef.h>
#include <string.h>

static char arena[ARENA];
static size_t used;
static long allocations;

void *malloc(size_t size) {
  ++allocations;
  size = (size + 15) / 16 * 16;
  if (used + size > sizeof arena) {
    return NULL;
  }
  void *memory = arena + used;
  used += size;
  return memory;
}

void *calloc(size_t n, size_t size) {
  return malloc(n * size); /* the arena is zero and never used twice */
}

void *realloc(void *memory, size_t size) {
  void *larger = malloc(size);
  if (memory && larger) {
    memcpy(larger, memory, size);
  }
  return larger;
}

void free(void *memory) {
  (void)memory;
}

#endif
