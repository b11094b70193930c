"""Tests of all parts; how they are run is in conftest.py, sampling.py and skips.py."""

import os

# The matrices of the tests are small, and xdist keeps every core busy: threads of BLAS would only
# wait for each other (a third of the processor time is left without them). Before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
