"""Values and units that the page of `flexhex view` writes."""

from __future__ import annotations

from tests.flexhex.browser import Browser
from tests.flexhex.test_view_browser import page, shown

__all__ = ["page", "shown"]


def test_scale_of_a_plot_has_the_prefix_that_fits_its_largest_value(shown: Browser) -> None:
    """errors of 20 µrad, torques of 1.5, angles of 0.1 rad; a value has its own prefix."""
    script = (
        "plots.charts.map(c => [c.box.querySelector('small').textContent, c.plot.scales.y.max])"
    )
    # all signals of these runs are said to be angles
    (e, e_most), (tau, tau_most), (theta, theta_most) = shown.run(script)
    assert (e.partition(" · ")[0], tau, theta) == ("µrad", "rad", "mrad")
    # each with room above it: the largest of joint 1
    assert 20 < e_most < 25
    assert 1.5 < tau_most < 1.8
    assert 120 < theta_most < 140


def test_rounding_is_shown_as_zero(shown: Browser) -> None:
    """The sine of 2 pi is no 8.56e-8 nrad; a reading of a thousandth of the smallest prefix is."""
    texts = {
        "8.56e-17, 'rad'": "0 rad",
        "0, 'N m'": "0 N m",
        "-2e-12, 'rad'": "−0.002 nrad",
        "-3.12e-5, 'rad'": "−31.2 µrad",
        "8.56e-17, 'kg'": "8.56e-17 kg",
    }
    # `shown` of the page, which writes values
    assert {given: shown.run(f"globalThis.shown({given})") for given in texts} == texts


def test_values_say_their_joint_and_times_their_unit(shown: Browser) -> None:
    """Without the colon joint 1 with 340 mN m read as 1340 mN m."""
    shown.run("setTime(2.5)")
    values = shown.run("[...document.querySelectorAll('.values b')].map(b => b.textContent)")
    assert all(text.startswith("1: ") for text in values)
    ticks = shown.run("plots.charts[0].plot.axes[0]._values")
    assert all(text.endswith(" s") for text in ticks if text)
