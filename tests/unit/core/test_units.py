"""The one table of units."""

import re

import pytest
from hypothesis import given, strategies as st
from tests.rows import refused, rows

import allanite as al
from allanite.core.units import ATOMS, SIGNALS, convert, signal_with, unit_of
from allanite.reporting.digits import in_ascii, printed_unit

SAME = [("deg/sqrt(h)", 2.908882e-4, "rad/sqrt(s)"), ("deg/h", 4.848137e-6, "rad/s"), ("arcsec", 4.848137e-6, "rad"),
        ("deg/h^1.5", 8.080228e-8, "rad/s^1.5"), ("deg/h^2", 1.346705e-9, "rad/s^2"),
        ("deg/h/sqrt(Hz)", 4.848137e-6, "rad/s/sqrt(Hz)"), ("ug/sqrt(Hz)", 9.80665e-6, "m/s^2/sqrt(Hz)"),
        ("ug/sqrt(Hz)", 5.88399e-4, "m/s/sqrt(h)")]  # fmt: skip


@rows(("unit", "factor", "to"), SAME)
def test_published_conversions(unit, factor, to):
    assert convert(1.0, unit, to) == pytest.approx(factor, rel=2e-7)


SPELLINGS = [("deg/sqrt(h)",
              ["°/√h", "deg/rth", "deg/h^0.5", "deg h^-0.5", "deg/sqrt(hr)", "deg/rt-hr", "deg/rt(h)", "deg/root-hour",
               "deg/√hr"]),
             ("deg/h", ["°/h", "dph", "deg/hr", "deg h^-1", "Deg/H"]),
             ("deg/s", ["dps", "DPS", "deg/sec", "°/s", "deg s-1"]),
             ("rad/sqrt(s)", ["rad/s/sqrt(Hz)", "rad/s/√Hz", "rad/(s*sqrt(Hz))", "rad*s^-0.5"]),
             ("rad/s^1.5", ["rad/s^2/sqrt(Hz)", "rad/s/sqrt(s)"]),
             ("deg/h/sqrt(Hz)", ["deg/h*sqrt(s)", "(deg/h)/rtHz"]), ("ug/sqrt(Hz)", ["µg/√Hz", "ug/rtHz", "ug/rt-Hz"]),
             ("m/s^2", ["m/s²", "m s^-2", "m/s2", "m s-2", "mps2"])]  # fmt: skip


@rows(("unit", "others"), SPELLINGS)
def test_every_spelling_is_one_unit(unit, others):
    for other in others:
        assert unit_of(other).dimension == unit_of(unit).dimension
        assert unit_of(other).factor == pytest.approx(unit_of(unit).factor, rel=1e-15)


SIZES = [-2.5, -2, -1.5, -1, -0.5, 0, 0.5, 1, 1.5]
SHOWN = {table[power] for signal in SIGNALS for table in (signal.si, signal.sheet) for power in SIZES}
SHOWN |= {*ATOMS, *(unit for signal in SIGNALS for unit in signal.density), "(deg/h)^2/Hz", "rad^2*s", "mdeg/sqrt(h)"}


@rows("unit", sorted(SHOWN))
def test_a_unit_that_is_shown_can_be_typed(unit):
    for shown in (printed_unit(unit), in_ascii(printed_unit(unit))):
        assert unit_of(shown) == unit_of(unit), shown
    assert not re.search(r"deg(?!C)|sqrt|\^", re.sub("[mu]deg", "", printed_unit(unit)))
    assert in_ascii(printed_unit(unit)).isascii()


@rows("text", ["'gx [deg/h]' is clipped", "--unit deg/h", "as is known to us"])
def test_names_and_what_is_typed_are_left_as_they_are(text):
    assert printed_unit(text) == text


@given(st.text(max_size=30))
def test_any_text_is_a_unit_or_an_error_that_lists_units(text):
    try:
        assert unit_of(text).factor > 0
    except al.UnitError as error:
        assert "arcsec" in str(error)  # noqa: PT017 - or it is a unit


@given(st.sampled_from(list(ATOMS)), st.sampled_from(list(ATOMS)))
def test_products_and_quotients_undo_each_other(a, b):
    whole = unit_of(f"{a}*{b}/{b}")
    assert whole.dimension == unit_of(a).dimension
    assert whole.factor == pytest.approx(unit_of(a).factor, rel=1e-14)


@rows("text, meant", [("deg/rt-hrr", "deg/sqrt(h)"), ("deg/hrr", "deg/h"), ("ug/rt-Hzz", "ug/sqrt(Hz)")])
def test_a_unit_with_a_root_is_never_mistaken_for_one_without(text, meant):
    refused(al.UnitError, re.escape(f"did you mean {meant}?"), lambda: unit_of(text))


def test_units_are_converted_where_they_fit():
    refused(al.UnitError, "dimensions differ", lambda: convert(1.0, "deg/h", "arcsec"))
    refused(al.UnitError, r"not a unit of N .*deg/sqrt\(h\)", lambda: al.N(1.0, "deg/h"))
    refused(al.UnitError, "different signals", lambda: al.N(1.0, "deg/sqrt(h)") + al.B(1.0, "ug"))
    assert (convert(1.0, "mA", "A"), convert(1.0, "gauss", "uT")) == (pytest.approx(1e-3), pytest.approx(100.0))
    assert unit_of("°C") == unit_of("degC") == unit_of("celsius") == unit_of("K")
    assert convert(5.0, "V/(V/A)", "A") == 5.0
    refused(al.UnitError, "their dimensions differ", lambda: convert(1.0, "A", "V"))


@rows("signal", SIGNALS, ids=lambda s: s.name)
def test_units_of_a_signal_are_the_signal_times_a_power_of_time(signal):
    for power in (1, 0.5, 0, -0.5, -1):
        expected = unit_of(signal.unit) * unit_of("s") ** power
        assert unit_of(signal.si[power]) == expected
        assert unit_of(signal.sheet[power]).dimension == expected.dimension
    for power, unit in (*signal.si.items(), *signal.sheet.items()):
        assert signal_with(unit_of(unit).dimension, power, values=True) is signal
