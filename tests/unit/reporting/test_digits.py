"""How many digits are printed."""

import math

from tests.rows import rows

from allanite.reporting.digits import digits


@rows("value, low, high, shown, interval", [
    (0.310213, 0.30217, 0.318712, "0.3102", "0.3022 .. 0.3187"),
    (12345.6, 11900.0, 12800.0, "12350", "11900 .. 12800"),
    (9.0241e-5, 8.79e-5, 9.251e-5, "9.02e-5", "8.79e-5 .. 9.25e-5"),
    (0.65, 0.29, 1.03, "0.65", "0.29 .. 1.03"),
    (1.0, 0.9004, 1.0996, "1.00", "0.90 .. 1.10"),  # the half width is 0.0996, and that is 0.10
    (0.3, 0.0, 25.0, "0.30", "0.00 .. 25.00"),  # never fewer than two digits of the value
    (3.2e6, 3.1e6, 3.3e6, "3.20e6", "3.10e6 .. 3.30e6"),
    (0.01, -0.0001, 0.02, "0.010", "0.000 .. 0.020"),  # no negative zero
    (0.0, -0.5, 0.5, "0.00", "-0.50 .. 0.50"),
    (1.9e-5, -0.2763, 0.2801, "0.00", "-0.28 .. 0.28"),  # near zero: as many as the interval needs
])  # fmt: skip
def test_value_and_limits_are_rounded_alike(value, low, high, shown, interval):
    assert digits(value, low, high).plain() == (shown, interval)


def test_a_number_without_an_interval_with_its_sign_and_in_print():
    assert digits(0.0123456).plain() == ("0.01235", "")
    assert digits(0.0123456, math.nan, math.nan, figures=2).plain() == ("0.012", "")
    assert digits(0.0).plain() == ("0", "")
    assert digits(0.45, 0.05, 0.85, signed=True).plain() == ("+0.45", "+0.05 .. +0.85")
    assert digits(-0.45, -0.85, -0.05, signed=True).plain() == ("-0.45", "-0.85 .. -0.05")
    assert digits(-9.0241e-5, -9.251e-5, -8.79e-5).pretty() == "−9.02 (−9.25 … −8.79) × 10⁻⁵"


@rows("half", [1e-9, 1e-7, 3e-4, 0.0995, 0.1, 7.0, 1e5])
@rows("value", [1e-9, 3e-4, 0.7, 42.0, 9.99999e5, 1e8])
def test_what_is_printed_is_within_half_a_digit(value, half):
    low, high = value - half, value + half
    shown, interval = digits(value, low, high).plain()
    assert abs(float(shown) - value) <= max(0.06 * half, 0.06 * value, 1e-11 * value)
    for text, limit in zip(interval.split(" .. "), (low, high), strict=True):
        assert abs(float(text) - limit) <= max(0.06 * half, 1e-11 * value)
