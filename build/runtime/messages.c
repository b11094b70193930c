/* Messages to the importer, and the mark of a refused call. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT_SIZE = 512 };

const char *const flexhex_categories[FLEXHEX_N_CATEGORIES] = {"logStatusError", "logStatusWarning",
                                                              "logEvents"};

const char *flexhex_number(char *text, double value) {
  if (isnan(value)) {
    return "nan"; /* printf would show its sign */
  }
  for (int digits = 15; digits <= 17; ++digits) {
    (void)snprintf(text, FLEXHEX_NUMBER_SIZE, "%.*g", digits, value);
    if (strtod(text, NULL) == value) {
      break;
    }
  }
  char *comma = strchr(text, ',');
  if (comma) {
    *comma = '.'; /* the importer's locale may write it so */
  }
  return text;
}

void flexhex_say(const fmi2CallbackFunctions *functions, const char *instance, fmi2Status status,
                 const char *category, const char *text) {
  if (!functions->logger) {
    return;
  }
  /* the importer reads the text as a format in which % and # are special */
  char escaped[2 * TEXT_SIZE];
  size_t length = 0;
  for (; *text && length < sizeof escaped - 2; ++text) {
    if (*text == '%' || *text == '#') {
      escaped[length++] = *text;
    }
    escaped[length++] = *text;
  }
  escaped[length] = '\0';
  functions->logger(functions->componentEnvironment, instance, status, category, escaped);
}

static void say_of(const flexhex_instance *m, fmi2Status status, flexhex_category category,
                   const char *format, va_list values) {
  char text[TEXT_SIZE];
  (void)vsnprintf(text, TEXT_SIZE, format, values);
  const size_t length = strlen(text);
  (void)snprintf(text + length, TEXT_SIZE - length, " (instance %s)", m->name);
  flexhex_say(&m->functions, m->name, status, flexhex_categories[category], text);
}

void flexhex_log(const flexhex_instance *m, fmi2Status status, flexhex_category category,
                 const char *format, ...) {
  if (m->logging & 1 << category) {
    va_list values;
    va_start(values, format);
    say_of(m, status, category, format, values);
    va_end(values);
  }
}

fmi2Status flexhex_refuse(flexhex_instance *m, const char *format, ...) {
  m->head->refused = 1;
  if (m->values[m->n_values - 1] == 0.0) {
    m->values[m->n_values - 1] = 1.0; /* a fault of step.c says more */
  }
  /* not subject to loggingOn: whoever ignores the status finds the reason at least here */
  va_list values;
  va_start(values, format);
  say_of(m, fmi2Error, FLEXHEX_ERRORS, format, values);
  va_end(values);
  return fmi2Error;
}
