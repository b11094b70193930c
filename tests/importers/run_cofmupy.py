"""Runs a cofmupy configuration in cofmupy's own environment: CONFIG STEPS STEP_SIZE RESULT.

It imports nothing of ours, since cofmupy pins an older FMPy. RESULT holds one row for each step.
"""

import json
import sys

import numpy as np
from cofmupy import Coordinator

config, steps, step_size, result = sys.argv[1:]
coordinator = Coordinator()
coordinator.start(config)
for _ in range(int(steps)):
    coordinator.do_step(float(step_size))
results = coordinator.get_results()
names = [key for key in results if key != "time"]
np.savez(
    result,
    names=json.dumps([".".join(name) for name in names]),
    rows=np.array([results[name] for name in names]).T,
    time=np.array(results["time"]),
)
