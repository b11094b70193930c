"""The numbers that decide, all of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Criteria:
    """Sizes are RMS of torque (force), relative to that of the axis; evidence is in nats.

    smallest_effect: smallest effect that is worth a name, beyond what the base model takes up.
    smallest_rest: smallest repeatable residual that is worth a word where nothing is named.
    largest_rest: largest one, relative to the torque of an effect, that leaves it its name.
    varied_rest: the same of an effect whose form machines have in many ways, as friction's.
    deviations: standard errors that a repeatable residual must stand above zero, and the gains of
    what is named.
    false_alarms: chance that any of the hypotheses of a search is accepted without reason.
    odds: two hypotheses whose evidence differs by less than this factor are not told apart.
    form_error: relative error of the functional form of an effect.
    exact_form_error: the same where the form is exact, as a sine is.
    loose: tolerances that a changed parameter may be off, as a standard deviation.
    shortlist: hypotheses of an axis whose shapes are searched between the points of the grid.
    most: effects of an axis that are accepted at most.
    predicted: least share, of the squares of the torque that an effect makes on held-out runs or of
        what is left there without it, that it explains there, where these decide.
    """

    smallest_effect: float = 0.003
    smallest_rest: float = 0.004
    largest_rest: float = 0.3
    varied_rest: float = 0.5
    deviations: float = 4.0
    false_alarms: float = 0.01
    odds: float = 20.0
    form_error: float = 0.10
    exact_form_error: float = 0.02
    loose: float = 20.0
    shortlist: int = 5
    most: int = 8
    predicted: float = 0.5

    def error_of(self, exact: bool) -> float:
        """Relative error of a functional form that is exact or is not."""
        return self.exact_form_error if exact else self.form_error


USUAL = Criteria()
