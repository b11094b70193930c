"""How fast it is, beside others: `python -m benchmarks`; docs/performance.md holds results."""

import os

# read when NumPy is imported, hence here: one core for everybody
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
# commands are measured as users run them: Python keeps what it has compiled
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
