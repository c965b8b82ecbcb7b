"""From a torquer's current to a rate, and what rounding adds to its noise."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from tests.rows import refused, rows

import allanite as al
from allanite.applications.signals import TorqueScale, rate_from_current
from allanite.applications.signals.stage import Codes, codes

SCALE = TorqueScale(turns=100, field=0.4, span=0.05, radius=0.05, inertia=2e-3, spin=1000.0, sides=4)
N, INTERVAL = 2.525648, 1e-3


def rates(seed=1, n=50_000, model=None):
    model = model or al.Model((al.N(N, "deg/sqrt(h)"),))
    return al.simulate(model, n, 1 / INTERVAL, rng=np.random.default_rng(seed), name="x")


def test_the_scale_factor_is_the_torque_over_the_momentum_and_keeps_the_history():
    assert SCALE.factor == pytest.approx(4 * 100 * 0.4 * 0.05 * 0.05 / (2e-3 * 1000))
    assert TorqueScale.parse(SCALE.text) == SCALE
    assert TorqueScale.parse("turns=1,field=2, span=3,radius=4,inertia=5,spin=6").sides == 1.0
    record = al.Record([1.0, math.nan, 2.0], 10.0, "A", name="ix", start=5.0, history=("cut",))
    rate = rate_from_current(record, 0.5)
    np.testing.assert_array_equal(rate.values, [0.5, math.nan, 1.0])
    assert (rate.name, rate.start, rate.history[0]) == ("ix", 5.0, "cut")


@rows("name", ["turns", "field", "span", "radius", "inertia", "spin", "sides"])
@rows("value", [0, -1.0, math.nan, math.inf, True, "1"])
def test_constants_are_positive(name, value):
    words = f"{name} must be (a number|between 1e-30)"
    refused(al.UsageError, words, lambda: replace(SCALE, **{name: value}))


SAME = [
    ([1.0, -2.0], "A", {}), ([1e3, -2e3], "mA", {}), ([0.5, -1.0], "V", {"sense": 0.5}),
    ([500.0, -1000.0], "mV", {"sense": 0.5}), ([512, -1024], "1", {"stage": al.signals.Stage("ADC", 12, 4.0, "A")}),
    ([1024, -2048], "1", {"sense": 0.5, "stage": al.signals.Stage("ADC", 14, 4.0, "V")}),
]  # fmt: skip


@rows("values, unit, options", SAME)
def test_all_ways_to_a_current_give_the_same_rate(values, unit, options):
    rate = rate_from_current(al.Record(values, 1000.0, unit), SCALE, **options)
    np.testing.assert_allclose(rate.values, [0.2, -0.4], rtol=1e-12)
    assert (rate.unit, rate.kind, rate.rate) == ("rad/s", "rate", 1000.0)
    assert "0.2 rad/s per A" in rate.history[-1]


WRONG = [
    ("V", 0.2, {}, "gain of its sensor"), ("A", -0.2, {}, "the scale, rad/s per A, must be between"),
    ("V", 0.2, {"sense": 0.0}, "the gain of the current sensor, V per A, must be between"),
    ("deg/s", 0.2, {}, "is in 'deg/s': a rate is computed from a current"), ("1", 0.2, {}, "computed from a current"),
    ("1", 0.2, {"stage": al.signals.Stage("ADC", 8, 1.0, "deg/s")}, "full scale in A or V"),
]  # fmt: skip


@rows("unit, scale, options, words", WRONG)
def test_what_gives_no_rate_is_said(unit, scale, options, words):
    record = al.Record([1, 2] if unit == "1" else [1.0, 2.0], 1.0, unit)
    refused(al.UsageError, words, lambda: rate_from_current(record, scale, **options))


@rows(("bits", "millivolts"), [(8, 39.06), (12, 2.44), (14, 0.610), (16, 0.153)])  # the paper prints the first two
def test_steps_of_converters_over_5_volts(bits, millivolts):
    assert 1e3 * al.signals.Stage("ADC", bits, 5.0, "V").step == pytest.approx(millivolts, rel=3e-3)


def test_rounding_an_angle_is_quantization():
    stage = al.signals.Stage("counter", 16, 32768.0, "arcsec")
    clean = rates(3, model=al.Model((al.N(0.5, "deg/sqrt(h)"),)))
    angle = np.round(np.degrees(clean.angle) * 3600)
    counts = al.Record(np.diff(angle), clean.rate, "arcsec", kind="count", scale=1.0, name="x")
    found = al.signals.budget(counts, [stage]).stages[0]
    assert (found.symbol, found.sheet_unit) == ("Q", "arcsec")
    assert found.coefficient == pytest.approx(math.radians(1 / 3600) / math.sqrt(12))
    assert found.to(found.measured) == pytest.approx(1 / math.sqrt(12), rel=0.1)
    assert found.codes is not None


def test_a_path_of_several_stages_from_the_current_on():
    stages = [al.signals.Stage("ADC", 12, 5.0, "V"), al.signals.Stage("output", 16, 500.0, "deg/s")]
    volts = 5.0 * rates(4).values / SCALE.factor
    recorded = al.Record(np.round(volts / stages[0].step) * stages[0].step, 1000.0, "V", name="ux")
    found = al.signals.budget(recorded, stages, scale=SCALE, sense=5.0)
    first, second = found.stages
    assert first.step == pytest.approx(stages[0].step / 5.0 * SCALE.factor)
    wanted = stages[1].step / math.sqrt(12) * math.sqrt(INTERVAL) * 60  # N of a stage by the formula, deg/sqrt(h)
    assert second.to(second.coefficient) == pytest.approx(wanted, rel=1e-9)
    assert first.codes.distinct > 500
    assert second.codes is None
    refused(al.UsageError, "give its relation to a rate", lambda: al.signals.budget(recorded, stages))
    refused(al.UsageError, "at least one stage", lambda: al.signals.budget(rates(), []))
    rate = al.signals.budget(recorded, [], scale=SCALE, sense=5.0).record
    np.testing.assert_allclose(rate.values, found.record.values, rtol=1e-12)


def test_codes_are_read_by_the_first_stage():
    stage = al.signals.Stage("ADC", 12, 5.0, "V")
    read = np.round(5.0 * rates(5).values / SCALE.factor / stage.step).astype(np.int64)
    found = al.signals.budget(al.Record(read, 1000.0, "1", name="ux"), [stage], scale=SCALE, sense=5.0).stages[0]
    assert found.to(found.measured) == pytest.approx(N, rel=0.02)
    assert found.codes == Codes(np.unique(read).size, int(np.ptp(read)) + 1, 0)


@rows("full_scale, count", [(4.0, 20), (3.0, 200)])
def test_clipped_readings_are_counted_and_refused_above_a_thousandth(full_scale, count):
    stage = al.signals.Stage("ADC", 12, full_scale, "deg/s")
    values = np.degrees(rates(6).values)
    limit = np.sort(np.abs(values))[-count]
    values = np.clip(values * full_scale / limit, -full_scale, full_scale - stage.step)
    record = al.Record(values, 1000.0, "deg/s", name="x")
    if count > 50:
        words = r"samples of 'x' \(0.\d+ %\) are clipped at the ends of ADC, 12 bits"
        refused(al.DataError, words, lambda: al.signals.budget(record, [stage]))
        return
    found = al.signals.budget(record, [stage])
    assert found.stages[0].clipped == count
    assert "clipped" in {f.name for f in found.findings}


@rows("unit", ["V", "1"], ids=["volts", "codes"])
def test_both_ends_of_a_converter_count_as_clipped(unit):
    stage = al.signals.Stage("ADC", 3, 4.0, "V")
    ends = al.Record([-4, -3, -2, -1, 0, 1, 2, 3] * 2, 1.0, unit)
    refused(al.DataError, "4 of 16 samples", lambda: rate_from_current(ends, 1.0, sense=1.0, stage=stage))
    inner = al.Record([-3, -2, -1, 0, 1, 2] * 2, 1.0, unit)
    assert rate_from_current(inner, 1.0, sense=1.0, stage=stage).size == 12


@pytest.mark.slow("takes more than half a second")
@rows("stage, offset, findings", [  # steps of 10 deg/s, noise of 1.3; so fine that hardly a code occurs twice
    (al.signals.Stage("output", 8, 1280.0, "deg/s"), 0.45, ["no dither"]),
    (al.signals.Stage("output", 24, 500.0, "deg/s"), 0.0, []),
])  # fmt: skip
def test_no_dither_is_said(stage, offset, findings):
    values = stage.step * np.round(np.degrees(rates(7).values) / stage.step + offset)
    found = al.signals.budget(al.Record(values, 1000.0, "deg/s", name="x"), [stage])
    assert [f.name for f in found.findings] == findings


def test_missing_codes_are_counted():
    stage = al.signals.Stage("ADC", 12, 100.0, "deg/s")
    k = np.round(np.degrees(rates(8).values) / stage.step)
    k[k == 3] = 4  # a converter that skips a code
    found = al.signals.budget(al.Record(k * stage.step, 1000.0, "deg/s", name="x"), [stage])
    assert found.stages[0].codes.missing == 1
    assert "missing codes" in {f.name for f in found.findings}


@given(st.lists(st.integers(-50, 50), min_size=2, max_size=60), st.floats(-3, 3))
def test_codes_are_counted_whatever_the_offset(values, offset):
    found = codes(np.array(values) + offset)
    assert found == Codes(len(set(values)), max(values) - min(values) + 1, 0)


STAGES = [("ADC 12 5V", ("ADC", 12, 5.0, "V")), ("output 16 +-100 deg/s", ("output", 16, 100.0, "deg/s")),
          ("bus 24 1e3mA", ("bus", 24, 1e3, "mA")), ("raw 12 2048", ("raw", 12, 2048.0, "1")),
          ("e 8 1.5e-2rad/s", ("e", 8, 0.015, "rad/s"))]  # fmt: skip


@rows("text, wanted", STAGES)
def test_stages_are_read_from_text(text, wanted):
    stage = al.signals.Stage(*wanted)
    assert al.signals.Stage.parse(text) == al.signals.Stage.parse(stage.text) == stage


@rows("text, error", [
    ("ADC", al.UsageError), ("ADC 12", al.UsageError), ("ADC x 5V", al.UsageError), ("ADC 0 5V", al.UsageError),
    ("ADC 12 -0V", al.UsageError), ("ADC 12 5parsec", al.UnitError), ("ADC 12 5Hz", al.UnitError),
])  # fmt: skip
def test_a_wrong_stage_is_named(text, error):
    with pytest.raises(error):
        al.signals.Stage.parse(text)
