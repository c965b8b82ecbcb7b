"""Whether the configured filter and rate are in the samples."""

import math
from functools import cache

import numpy as np
from scipy.signal import butter, lfilter
from tests.rows import rows

import allanite as al
from allanite.claims.checking import setting_rows
from allanite.claims.claim import settings_in
from allanite.claims.result import AGREES, DIFFERS, NOT_DECIDED

RATE, SIZE, START = 200.0, 12_000, 500


def noise():
    return 1e-3 * np.random.default_rng(3).standard_normal(SIZE + START)


SAMPLES = {
    "none": lambda: noise()[START:],
    "rc": lambda: lfilter([1 - math.exp(-0.3 * math.pi)], [1, -math.exp(-0.3 * math.pi)], noise())[START:],
    "butterworth": lambda: lfilter(*butter(2, 42.0, fs=RATE), noise())[START:],
    "average": lambda: np.convolve(noise(), np.full(4, 0.25))[START : START + SIZE],
    "held": lambda: np.repeat(noise()[: SIZE // 2], 2),
    "coarse": lambda: 2e-3 * np.round(noise()[START:] / 2e-3),
}


@cache
def study_of(name, **choices):
    return al.analyze(al.Record(SAMPLES[name](), RATE, "rad/s", name="gx"), **choices)


@rows("name, claim, outcome, said", [
    ("rc", "lowpass 30 Hz", AGREES, ""),
    ("rc", "lowpass 45 Hz", DIFFERS, "the low-pass of the record lies between"),
    ("butterworth", "lowpass 42 Hz", AGREES, ""),
    ("butterworth", "lowpass 95 Hz", NOT_DECIDED, "a higher sampling rate is needed"),
    ("average", "lowpass 22.15 Hz", AGREES, ""),
    ("none", "lowpass 42 Hz", DIFFERS, "the record shows no low-pass below"),
    ("none", "rate 200 Hz", AGREES, ""),
    ("none", "rate 100 Hz", DIFFERS, "none of the 200 samples a second is a repeated one"),
    ("none", "rate 400 Hz", NOT_DECIDED, "does not show whether the sensor has more"),
    ("held", "rate 100 Hz", AGREES, ""),
    ("held", "rate 200 Hz", DIFFERS, "held from 100 Hz"),
    ("held", "lowpass 42 Hz", NOT_DECIDED, "a longer record"),
    ("coarse", "rate 100 Hz", NOT_DECIDED, "too coarse"),
])  # fmt: skip
def test_a_setting_is_confirmed_contradicted_or_not_decided_on(name, claim, outcome, said):
    settings, _ = settings_in(claim)
    (row,) = setting_rows(study_of(name), settings, 0.05, 0.02)
    assert (row.outcome, row.claimed) == (outcome, settings[0].value)
    assert said in row.reason
    assert outcome != AGREES or (row.low <= 1.02, row.high >= 0.98) == (True, True)


def test_without_all_frequencies_no_filter_is_decided_on():
    (row,) = setting_rows(study_of("none", band="all"), settings_in("lowpass 42 Hz")[0], 0.05, 0.02)
    words = "filters are looked for where all frequencies are read, by the method whittle"
    assert (row.outcome, row.reason) == (NOT_DECIDED, words)


def test_the_limits_of_a_cut_off_hold_it_and_grow_with_the_level():
    fit = study_of("butterworth")["gx"].fit
    (low, high), (least, most) = fit.cutoff(0.95), fit.cutoff(0.999)
    assert least < low < 42.0 < high < most < 50.0
    low, high = study_of("none")["gx"].fit.cutoff(0.95)
    assert low > 0.35 * RATE
    assert math.isinf(high)


def test_settings_are_combined_with_noise():
    record = al.Record(SAMPLES["butterworth"](), RATE, "rad/s", name="gx")
    claim = "N 0.243 deg/sqrt(h), lowpass 42 Hz, rate 200 Hz; accel lowpass 5 Hz"
    found = al.check(record, claim)
    outcomes = {row.quantity: row.outcome for row in found.terms}
    assert outcomes == dict.fromkeys(("N", "curve", "kurtosis", "cutoff", "rate"), AGREES)
    assert found.choices()["claims"] == "N 0.243 deg/sqrt(h), lowpass 42 Hz, rate 200 Hz, accel lowpass 5 Hz"
    wrong, undecided = al.check(record, "gyro lowpass 20 Hz"), al.check(record, "lowpass 95 Hz")
    assert (wrong.agrees, [cause.quantity for cause in wrong.causes]) == (False, ["cutoff"])
    words = "the record neither confirms nor contradicts the claim"
    assert (undecided.agrees, undecided.verdict) == (True, words)
