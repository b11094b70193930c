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

static void compose(char *text, const flexhex_instance *m, const char *format, va_list values) {
  (void)vsnprintf(text, TEXT_SIZE, format, values);
  const size_t length = strlen(text);
  (void)snprintf(text + length, TEXT_SIZE - length, " (instance %s)", m->name);
}

static const char *category_name(flexhex_category category) {
  return flexhex_categories[category == FLEXHEX_ERRORS ? 0 : category == FLEXHEX_WARNINGS ? 1 : 2];
}

void flexhex_log(const flexhex_instance *m, fmi2Status status, flexhex_category category,
                 const char *format, ...) {
  if (!(m->logging & (int)category)) {
    return;
  }
  char text[TEXT_SIZE];
  va_list values;
  va_start(values, format);
  compose(text, m, format, values);
  va_end(values);
  flexhex_say(&m->functions, m->name, status, category_name(category), text);
}

fmi2Status flexhex_refuse(flexhex_instance *m, const char *format, ...) {
  char text[TEXT_SIZE];
  va_list values;
  va_start(values, format);
  compose(text, m, format, values);
  va_end(values);
  m->head->refused = 1;
  if (m->values[m->n_values - 1] == 0.0) {
    m->values[m->n_values - 1] = 1.0; /* a fault of the room says more */
  }
  /* not subject to loggingOn: whoever ignores the status finds the reason at least here */
  flexhex_say(&m->functions, m->name, fmi2Error, category_name(FLEXHEX_ERRORS), text);
  return fmi2Error;
}
