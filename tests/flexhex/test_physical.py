"""A fit whose noise takes masses or stiffness below zero, as plant.fmu can be given it."""

from __future__ import annotations

import numpy as np
import pytest

from flexhex.diagnose.physical import below, physical
from flexhex.diagnose.replay import plant_values
from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters


def test_what_is_below_zero_goes_to_zero_and_the_rest_follows(machine: Machine) -> None:
    names = [par.name for par in parameters(machine)]
    first, second = names.index("lower.J_yy"), names.index("flexure.k_s1")
    nominal = base_parameters(machine)
    p = nominal.copy()
    # the lower arm's own moment is 0.0168 kg m2; regrouped it is below zero in any case
    p[first] -= 0.02
    covariance = np.diag(np.full(len(p), 1e-4))
    covariance[first, second] = covariance[second, first] = 0.5e-4
    fit = Fit(p, np.full(len(p), 0.01), np.zeros(6), 1.0, 0, (), covariance=covariance)
    assert below(machine, nominal) == ()
    assert below(machine, p) == tuple(f"lower[{k}].J_yy" for k in range(1, 7))
    better = physical(machine, fit).p
    short = 0.02 - 0.0168057
    assert better[first] - p[first] == pytest.approx(short, abs=1e-6)
    assert better[second] - p[second] == pytest.approx(0.5 * short, abs=1e-6)
    others = np.delete(better - p, [first, second])
    assert np.abs(others).max() < 1e-15
    held = plant_values(machine, better)["mechanism"][8::17][:6]
    assert (held > 0).all()
    assert held.max() < 1e-8
    assert below(machine, better) == ()


def test_a_fit_that_a_machine_has_stays(machine: Machine) -> None:
    p = base_parameters(machine)
    fit = Fit(p, np.zeros_like(p), np.zeros(6), 1.0, 0, ())
    assert physical(machine, fit) is fit
