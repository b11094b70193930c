"""What came before a signal and what comes after it, by linear prediction: its waves go on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Continued:
    """Means (3 count, n) of values over `every` samples each, so many apart: before them, along
    them, and after them."""

    every: int
    means: Array

    @staticmethod
    def of(values: Array, most: int) -> Continued:
        """Of values (samples, n), along which there are at most about `most` means."""
        every = 2 * (len(values) // most // 2) + 1
        reach, count = every // 2, (len(values) - every // 2 - 1) // every
        listed = list[Array]()
        for own in values.T:
            # the first mean is a step after the first sample, which is predicted, too
            means = own[every - reach :][: every * count].reshape(count, every).mean(axis=1)
            weights = prediction(means)
            back, ahead = (predicted(way, weights, count) for way in (means[::-1], means))
            listed.append(np.concatenate([back[::-1], means, ahead]))
        return Continued(every, np.stack(listed, axis=1))

    @property
    def lead(self) -> int:
        """Samples before the first one."""
        return self.every * (len(self.means) // 3 - 1)

    def around(self, values: Array, axis: int, rested: bool) -> Array:
        """The values of an axis (samples,) with what came before, nothing where it `rested`, and
        what comes after."""
        means, at = self.means[:, axis].copy(), self.every * np.arange(len(self.means))
        means[: len(means) // 3] *= not rested
        whole = np.interp(np.arange(at[-1] + 1), at, means)
        whole[self.lead : self.lead + len(values)] = values
        return whole


def prediction(values: Array) -> Array:
    """Weights (order + 1,) whose sum with a value and those before it, the last first, is next to
    zero all along values (m,): those of a third as many that do not let them grow (Burg 1975).
    Backwards they are the same."""
    forward, backward, weights = values[1:], values[:-1], np.ones(1)
    for _ in range(len(values) // 3):
        power = float(forward @ forward + backward @ backward)
        if power == 0.0:
            break
        turned = -2.0 * float(forward @ backward) / power
        longer = np.append(weights, 0.0)
        weights = longer + turned * longer[::-1]
        ahead, behind = forward + turned * backward, backward + turned * forward
        forward, backward = ahead[1:], behind[:-1]
    return weights


def predicted(values: Array, weights: Array, count: int) -> Array:
    """So many values (count,) after these (m,), see `prediction`."""
    from scipy.signal import lfilter, lfiltic  # takes long to load

    begun = lfiltic([1.0], weights, values[::-1][: len(weights) - 1])
    return np.asarray(lfilter([1.0], weights, np.zeros(count), zi=begun)[0])
