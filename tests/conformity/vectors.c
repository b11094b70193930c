/* Plays inputs through an FMU's shared library and prints every output's bits, so that other
   computers can be compared: `vectors LIBRARY TABLE`.

   TABLE: guid, inputs (count, references), outputs (count, references), step [s], rows (count),
   then the inputs of each row, each number in hexadecimal bits. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
static void *find(void *library, const char *name) {
  FARPROC address = GetProcAddress((HMODULE)library, name);
  void *plain = NULL;
  memcpy(&plain, &address, sizeof plain);
  return plain;
}
#define OPEN(path) ((void *)LoadLibraryA(path))
#else
#include <dlfcn.h>
#define find dlsym
#define OPEN(path) dlopen(path, RTLD_NOW)
#endif

enum { MOST = 4096 };

static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
  (void)environment, (void)name, (void)status, (void)category;
  fprintf(stderr, "%s\n", message);
}

/* The function of that name; writing it as bytes is what every platform allows. */
#define GET(type, name)                   \
  type *name = NULL;                      \
  {                                       \
    void *address = find(library, #name); \
    if (!address) {                       \
      fprintf(stderr, "no %s\n", #name);  \
      return 3;                           \
    }                                     \
    memcpy(&name, &address, sizeof name); \
  }

static double number(FILE *file) {
  uint64_t bits = 0;
  double value = 0.0;
  if (fscanf(file, "%" SCNx64, &bits) != 1) {
    fprintf(stderr, "the table ends too early\n");
    exit(4);
  }
  memcpy(&value, &bits, sizeof value);
  return value;
}

static size_t references(FILE *file, fmi2ValueReference *list) {
  unsigned n = 0;
  if (fscanf(file, "%u", &n) != 1 || n > MOST) {
    exit(4);
  }
  for (unsigned k = 0; k < n; ++k) {
    if (fscanf(file, "%u", list + k) != 1) {
      exit(4);
    }
  }
  return n;
}

int main(int count, char **arguments) {
  static fmi2ValueReference in[MOST], out[MOST], whole[MOST], flags[MOST];
  static double values[MOST];
  static int numbers[MOST];
  char guid[64];
  unsigned rows = 0;
  FILE *file = count == 3 ? fopen(arguments[2], "r") : NULL;
  void *library = file ? OPEN(arguments[1]) : NULL;
  if (!library || fscanf(file, "%63s", guid) != 1) {
    fprintf(stderr, "cannot open %s\n", count == 3 ? arguments[1] : "anything");
    return 2;
  }
  GET(fmi2InstantiateTYPE, fmi2Instantiate)
  GET(fmi2EnterInitializationModeTYPE, fmi2EnterInitializationMode)
  GET(fmi2ExitInitializationModeTYPE, fmi2ExitInitializationMode)
  GET(fmi2GetRealTYPE, fmi2GetReal)
  GET(fmi2SetRealTYPE, fmi2SetReal)
  GET(fmi2GetIntegerTYPE, fmi2GetInteger)
  GET(fmi2GetBooleanTYPE, fmi2GetBoolean)
  GET(fmi2DoStepTYPE, fmi2DoStep)
  const size_t n_in = references(file, in), n_out = references(file, out);
  const size_t n_whole = references(file, whole), n_flags = references(file, flags);
  const double step = number(file);
  static const fmi2CallbackFunctions callbacks = {hear, NULL, NULL, NULL, NULL};
  fmi2Component c =
      fmi2Instantiate("vectors", fmi2CoSimulation, guid, NULL, &callbacks, fmi2False, fmi2False);
  if (!c || fscanf(file, "%u", &rows) != 1) {
    return 5;
  }
  int bad = fmi2EnterInitializationMode(c) != fmi2OK || fmi2ExitInitializationMode(c) != fmi2OK;
  for (unsigned n = 0; n < rows; ++n) {
    for (size_t k = 0; k < n_in; ++k) {
      values[k] = number(file);
    }
    bad += fmi2SetReal(c, in, n_in, values) != fmi2OK;
    bad += fmi2DoStep(c, n * step, step, fmi2True) != fmi2OK;
    bad += fmi2GetReal(c, out, n_out, values) != fmi2OK;
    for (size_t k = 0; k < n_out; ++k) {
      uint64_t bits = 0;
      memcpy(&bits, values + k, sizeof bits);
      printf("%016" PRIx64 "\n", bits);
    }
    bad += fmi2GetInteger(c, whole, n_whole, numbers) != fmi2OK;
    bad += fmi2GetBoolean(c, flags, n_flags, numbers + n_whole) != fmi2OK;
    for (size_t k = 0; k < n_whole + n_flags; ++k) {
      printf("%016x\n", (unsigned)numbers[k]);
    }
  }
  return bad ? 6 : 0;
}
