"""A gas spring that balances an axis, an effect of your own for `flexhex diagnose`:

flexhex diagnose RUN... --effect FILE.py:GasSpring

and for a hexapod's machine file: `id = "FILE.py:GasSpring"` in its `[[effects]]`.
"""

from typing import Any

import numpy as np


class GasSpring:
    # linear parameters: name and unit; ("F", "N m", "positive") where it cannot be negative
    gains = (("F", "N m", "positive"),)
    # others: name, unit, values to try; what lies between them is searched, too
    shapes = (("ratio", "1", (1.1, 1.3, 1.6, 2.0, 3.0)),)

    def columns(self, axis: Any, ratio: float) -> Any:
        """Torque on an axis for one of each gain, (samples, gains).

        The spring hangs at a crank of length 1 and a foot `ratio` away: its arm about the joint.
        """
        length = np.sqrt(1 + ratio**2 - 2 * ratio * np.cos(axis.theta))
        return ratio * np.sin(axis.theta)[:, None] / length[:, None]
