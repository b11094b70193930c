"""How large an effect is, in a sentence: digits that are known, where it is seen, what it means."""

from __future__ import annotations

import math
from dataclasses import replace

from flexhex.diagnose.effects import undetermined
from flexhex.diagnose.view import changed_rows
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.result.naming import by_name
from flexhex.diagnosis.result.verdict import Changed, Named
from tests.flexhex.diagnoses import BASIC, EXAMPLES, estimate


def test_sizes_say_where_an_effect_is_seen_and_what_a_gain_means() -> None:
    waves = {
        "a": estimate(0.03, 0.001),
        "b": estimate(0.04, 0.001),
        "order": estimate(80.0, 0.1, "1/rad"),
        "a#2": estimate(0.01, 0.001),
        "b#2": estimate(0.0, 0.001),
        "order#2": estimate(160.0, 0.1, "1/rad"),
    }
    two = replace(BASIC, effects=(Named("cogging_harmonic", "", (1,), waves),))
    assert "of 0.0500 and 0.0100 N m with 80 and 160 periods a turn that" in verdict(two)
    line = {name: replace(e, unit="1/m") if "order" in name else e for name, e in waves.items()}
    two = replace(BASIC, effects=(Named("cogging_harmonic", "", (1,), line),))
    assert "of 0.0500 and 0.0100 N m with periods of 78.54 and 39.27 mm that" in verdict(two)
    vague = {"J_2": estimate(0.0057, 0.0009, "kg m2"), "f": estimate(8.928, 0.5, "Hz")}
    mode = replace(BASIC, effects=(Named("flexible_mode", "", (1,), vague),))
    assert "of 0.0057 ± 0.0009 kg m² at 8.9 Hz that" in verdict(mode)
    wide = waves | {"order": estimate(28.0, 18.0, "1/m"), "order#2": estimate(56.1, 3.0, "1/m")}
    two = replace(BASIC, effects=(Named("cogging_harmonic", "", (1,), wide),))
    assert "with periods of 220 and 112 mm that" in verdict(two)
    gain = replace(BASIC, effects=(Named("drive_gain", "", (2,), {"g": estimate(0.2, 0.01, "1")}),))
    assert "(the drive reports 1.250 times what the joint gets) that" in verdict(gain)
    dry = {"F_c": estimate(4.0, 0.2), "F_s": estimate(2.5, 0.2)}
    diagnosis = replace(BASIC, effects=(Named("stribeck_friction", "", (1,), dry),))
    assert "of 4.0 ± 0.2 N m (breakaway at 6.5 N m) that" in verdict(diagnosis)
    limit = {"clip": estimate(0.98, 0.05, "1"), "tau_lim": estimate(8.6, 0.25, "N m")}
    diagnosis = replace(BASIC, effects=(Named("torque_saturation", "", (1,), limit),))
    assert "a torque limit of 8.6 ± 0.2 N m that" in verdict(diagnosis)


def test_no_sentence_or_table_has_unit_1() -> None:
    """It would read as a second number."""
    parts = tuple((axis, {"g": estimate(0.1 * axis, 0.01, "1")}) for axis in (1, 2, 3, 4))
    gains = Named("drive_gain", "", (1, 2, 3, 4), by_name(parts), parts)
    assert "of 0.100 to 0.400 that" in verdict(replace(BASIC, effects=(gains,)))
    open_ = replace(gains, axes=(1,), parts=((1, {"g": estimate(0.1, math.inf, "1")}),))
    (line,) = undetermined(replace(BASIC, effects=(open_,)))
    assert line.endswith("(in the fit: 0.100)")
    changed = (Changed("ratio", 0.0, estimate(0.1, 0.01, "1")),)
    other = replace(EXAMPLES["changed"], changed=changed)
    assert verdict(other).endswith("ratio is 0.100 ± 0.010, not 0.")
    assert changed_rows(other)[0][-1] == ""
