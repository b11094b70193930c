/* Drives the executor without Python, as the gateway does: a component of the host's own
   stamps the bus, a relay FMU passes the stamp on. Arguments: library, GUID, period of the
   relay, highest stamp to send, and `play` to have the executor write the stamps. Prints the stamps
   that the relay shows, or the message. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "executor.h"

enum { HOST = 0, RELAY = 1, STEPS = 24 };

int main(int argc, char **argv) {
  /* relay: Ts 0, keep 1, u[1] 2, u[2] 3, v 4, y[1] 5 */
  const fmi2ValueReference inputs[] = {2, 3, 4}, outputs[] = {5};
  const size_t sources[] = {0, 1, 1}, logged[] = {2};
  double rows[STEPS + 1], stamps[STEPS + 1][2];
  char message[256] = "";
  executor_log log = {0};
  executor_component components[2] = {{0}, {0}};
  executor *e;
  int64_t n;
  if (argc != 5 && argc != 6) {
    return 2;
  }
  components[HOST].name = "host";
  components[HOST].period = 1;
  components[HOST].outputs.n_reals = 2;
  components[RELAY].name = "relay";
  components[RELAY].library = argv[1];
  components[RELAY].guid = argv[2];
  components[RELAY].resources = "file:///";
  components[RELAY].period = atoll(argv[3]);
  components[RELAY].inputs.n_reals = 3;
  components[RELAY].inputs.references = inputs;
  components[RELAY].sources = sources;
  components[RELAY].outputs.n_reals = 1;
  components[RELAY].outputs.references = outputs;
  components[RELAY].slot = 2;
  log.period = components[RELAY].period;
  log.n_slots = 1;
  log.slots = logged;
  log.rows = rows;
  log.capacity = STEPS + 1;
  e = executor_open(components, 2, 3, 0.00025, &log, 1, true, message, sizeof message);
  if (e == NULL) {
    printf("%s\n", message);
    return 1;
  }
  for (n = 0; n <= STEPS; n++) {
    stamps[n][0] = (double)n * atof(argv[4]) / STEPS;
    stamps[n][1] = 0.0;
  }
  if (argc == 6) {
    executor_play(e, stamps[0], STEPS + 1, 0, 2);
  }
  for (n = 0; n <= STEPS; n++) {
    if (argc == 5) {
      executor_bus(e)[0] = stamps[n][0];
    }
    if (!executor_run(e, n + (n < STEPS))) {
      printf("%s\n", executor_message(e));
      executor_close(e);
      return 1;
    }
  }
  for (n = 0; n < (int64_t)log.count; n++) {
    printf("%g ", rows[n]);
  }
  printf("\nnow %" PRId64 ", %" PRIu64 " steps\n", executor_now(e),
         executor_time_of(e, RELAY).steps);
  executor_close(e);
  return 0;
}
