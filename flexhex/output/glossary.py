"""Words of the reports, explained where they stand; docs/glossary.md says the same."""

from __future__ import annotations

from typing import Any

TERMS = {
    "N_F": "forward kinematics of the setpoints, by Newton-Raphson: all coordinates of the"
    " mechanism from the six angles",
    "N_E": "the same forward kinematics of the measured motion, for the estimator",
    "F": "feedforward: inverse dynamics with the estimated parameters",
    "W": "filter: Hann window and derivatives of angle and torque",
    "K": "estimator: regressor of the parameters and Kalman filter",
    "p": "the parameters of the model: actuators, inertias, stiffnesses",
    "e": "tracking error: setpoint minus joint angle",
    "τ_FB": "torque of the feedback",
    "τ_FF": "torque of the feedforward",
    "feedback only": "PID alone, feedforward switched off",
    "fixed": "feedforward with the parameters that were fitted to another trajectory",
    "adaptive": "the same parameters, adapted by the Kalman filter during the run",
    "exact plant": "the plant is the model itself, so that only numerics and delays remain",
    "repeatable": "what all passes of a trajectory have in common: a better model could explain it",
    "non-repeatable": "the rest: noise, disturbance, drift between passes; no model of the motion"
    " explains it",
    "pass": "one repetition of a trajectory",
    "held-out run": "run that takes no part in the fit; it judges the result",
    "residual": "measured torque minus the torque of the fitted model",
    "effect": "a physical cause with its equation: friction, cogging, a lag, …",
    "crossover": "frequency up to which the feedback follows: its open loop has gain 1 there",
    "not determined": "the data say nothing about this parameter by itself, only about a"
    " combination with others",
}
"""Word -> meaning, in the words of docs/glossary.md."""


def term(word: str, shown: str | None = None) -> Any:
    """A word with its meaning on hover and focus, as safe HTML (markupsafe.Markup).

    shown: the word as the sentence has it. KeyError for a word that is not explained.
    """
    from markupsafe import Markup

    symbol, _, index = (shown or word).partition("_")
    text = Markup("{}<sub>{}</sub>").format(symbol, index) if index else Markup("{}").format(symbol)
    return Markup('<span class="term" tabindex="0" data-tip="{}">{}</span>').format(
        TERMS[word], text
    )
