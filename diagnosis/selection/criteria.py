"""The numbers that decide, all of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Criteria:
    """Sizes are RMS of torque (force), relative to that of the axis.

    smallest_effect: smallest gain on left-out trajectories that is worth a name.
    smallest_rest: smallest repeatable residual that is worth a word.
    deviations: standard errors that a gain, or a repeatable residual, must stand above zero.
    alike: standard errors within which two hypotheses predict equally well.
    form_error: relative error of an effect's functional form, smooth in its own arguments.
    exact_form_error: the same where the form is exact, as a sine is.
    looseness: standard deviation of a base parameter in the fit, relative to its tolerance.
    promising: fall of the whitened sum of squares from which a hypothesis is scored.
    shortlist: hypotheses of an axis that are scored on left-out trajectories in a round.
    most: terms that are accepted at most.
    """

    smallest_effect: float = 0.002
    smallest_rest: float = 0.004
    deviations: float = 3.0
    alike: float = 1.0
    form_error: float = 0.10
    exact_form_error: float = 0.02
    promising: float = 12.0
    shortlist: int = 6
    most: int = 12


USUAL = Criteria()
