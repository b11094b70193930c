"""How often the diagnosis is right, on machines drawn at random."""

import os

# read when NumPy is imported, hence here: small matrices, and the draws run side by side
for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
