"""What is right agrees, and what is wrong is found and explained."""

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.rows import refused, rows

import allanite as al
from allanite.claims.result import AGREES, CONTRADICTS, DIFFERS, EXCEEDS, NOT_DECIDED, UNCLAIMED
from allanite.study.analysis import analyzed
from allanite.terms import TERMS

RATE, SIZE = 50.0, 20_000
GYRO, ACCELEROMETER = "N 1 deg/sqrt(h), K 300 deg/h/sqrt(h)", "N 100 ug/sqrt(Hz)"


def simulated(model, name, seed):
    return al.simulate(al.Model(model), SIZE, RATE, rng=seed, name=name)


@pytest.fixture(scope="module")
def recording():
    return al.Recording((simulated(GYRO, "gx", 1), simulated(GYRO, "gy", 2), simulated(ACCELEROMETER, "ax", 3)))


@pytest.fixture(scope="module", autouse=True)
def _analyzed_once():
    """The same records are held against many claims."""
    known = {}

    def once(source, recipe, progress=None):
        key = id(source), str(recipe)
        known[key] = known.get(key) or (source, analyzed(source, recipe, progress))
        return known[key][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("allanite.claims.checking.analyzed", once)
        yield


def outcomes(found, channel):
    return {row.quantity: row.outcome for row in found.terms if row.channel == channel}


@pytest.mark.slow("takes more than half a second")
def test_what_is_claimed_rightly_agrees(recording):
    found = al.check(recording, f"{GYRO}; {ACCELEROMETER}")
    assert found.agrees
    assert not found.causes
    assert outcomes(found, "gx") == dict.fromkeys(("N", "K", "curve", "kurtosis"), AGREES)
    assert found.verdict == "the record agrees with the claim"
    headings, rows = found.rows()
    assert len(headings) == len(rows[0])
    for row in found.terms:
        assert row.quantity == "kurtosis" or row.low < row.ratio < row.high


@rows(("factor", "name"), [
    (2**0.5, "sqrt(2)"), (2**-0.5, "1/sqrt(2)"), (RATE**0.5, "sqrt(rate)"), (1 / RATE, "1/rate"), (60, "60"),
    (300, ""), (1.05, ""),
])  # fmt: skip
def test_the_factor_of_white_noise_is_found_and_named(recording, factor, name):
    found = al.check(recording["gx"], f"N {1 / factor} deg/sqrt(h), K 300 deg/h/sqrt(h)")
    (cause,) = found.causes
    assert (cause.channels, cause.quantity, cause.names) == (("gx",), "N", (name,) if name else ())
    assert cause.low < factor < cause.high
    assert cause.words.startswith("N is ")


@pytest.mark.slow("takes more than half a second")
def test_noise_that_is_not_claimed_is_found(recording):
    found = al.check(recording, "N 1 deg/sqrt(h)")
    assert {c.record.name for c in found.checked} == {"gx", "gy"}
    slow = [{name for name, outcome in outcomes(found, axis).items() if outcome == UNCLAIMED} for axis in ("gx", "gy")]
    assert slow == [{"R"}, {"K"}]  # the walk of gx goes one way, and its likelihood is that of a ramp
    assert not found.agrees


BESIDE_WHITE = {
    "Q": "Q 3 arcsec", "F": "F 3 arcsec", "N": "", "B": "B 100 deg/h", "K": "K 300 deg/h/sqrt(h)",
    "R": "R -3000 deg/h^2", "W": "W 200 deg/h 60 s", "GM": "GM 100 deg/h 10 s", "GML": "GML 100 deg/h 10 s",
    "GMA": "GMA 9 arcsec 2 s", "GM2": "GM2 100 deg/h 0.3 Hz 0.3", "Sine": "Sine 100 deg/h 2 Hz",
}  # fmt: skip
"""Each term, well seen beside N 1 deg/sqrt(h) in the records of this file."""


@rows("symbol", TERMS)
def test_each_term_agrees_with_the_claim_that_is_true(symbol):
    model = ", ".join(filter(None, ("N 1 deg/sqrt(h)", BESIDE_WHITE[symbol])))
    record = simulated(model, "gx", 11)
    exact, bound = al.check(record, model), al.check(record, model, at_most=True)
    assert [(row.quantity, row.outcome) for row in (*exact.terms, *bound.terms) if row.contradicts] == []
    assert symbol in outcomes(exact, "gx")


@rows("model, unclaimed", [
    ("N 1 deg/sqrt(h), R 900 deg/h^2", {"R"}), ("N 1 deg/sqrt(h), R -1e6 deg/h^2", {"R"}),
    ("N 1 deg/sqrt(h), B 50 deg/h, R 20000 deg/h^2", {"R", "B"}), ("N 1 deg/sqrt(h), K 2000 deg/h/sqrt(h)", {"K"}),
])  # fmt: skip
def test_a_ramp_and_a_random_walk_that_are_not_claimed_are_told_apart(model, unclaimed):
    found = al.check(simulated(model, "gx", 7), "N 1 deg/sqrt(h)")
    own = {row.quantity: row for row in found.terms}
    assert {name for name, row in own.items() if row.outcome == UNCLAIMED} == unclaimed
    assert own["N"].outcome == AGREES
    if "R" in unclaimed:
        assert own["R"].found == pytest.approx(abs(al.Model(model)["R"].value), rel=0.15)


def test_a_bias_that_is_missing_is_said(recording):
    found = al.check(recording["ax"], "N 100 ug/sqrt(Hz), K 3000 ug/sqrt(h)")
    (cause,) = found.causes
    assert cause.quantity == "K"
    assert "the record has no such bias" in cause.words


@rows("claim, options, expected", [
    ("N 1.5 deg/sqrt(h)", {"at_most": True}, {"N": AGREES, "curve": EXCEEDS}),
    ("N 1.5 deg/sqrt(h), K 600 deg/h/sqrt(h)", {"at_most": True}, {"N": AGREES, "K": AGREES, "curve": AGREES}),
    ("N 0.9 deg/sqrt(h), K 600 deg/h/sqrt(h)", {"at_most": True}, {"N": EXCEEDS, "K": AGREES, "curve": EXCEEDS}),
    ("N 0.97 deg/sqrt(h), K 300 deg/h/sqrt(h)", {"tolerance": 0.1}, {"N": AGREES, "K": AGREES, "curve": AGREES}),
    ("N 0.97 deg/sqrt(h), K 300 deg/h/sqrt(h)", {"tolerance": 0.0}, {"N": DIFFERS, "K": AGREES}),
    ("N 1.5 deg/sqrt(h), GM 1 deg/h 20 s", {"at_most": True}, {"GM": NOT_DECIDED}),
])  # fmt: skip
def test_bounds_and_tolerance(recording, claim, options, expected):
    found = al.check(recording["gx"], claim, **options)
    assert {key: value for key, value in outcomes(found, "gx").items() if key in expected} == expected
    assert found.agrees == (not any(row.outcome in CONTRADICTS for row in found.terms))


@pytest.mark.slow("takes more than half a second")
def test_limits_and_data_sheets_are_held_against_each_channel(recording, tmp_path):
    file = tmp_path / "limits.toml"
    file.write_text('[limits]\nN = { max = "1.2 deg/sqrt(h)" }\nminimum = { max = "1000 deg/h" }\n[channels.ax]\n'
                    'N = { max = "50 ug/sqrt(Hz)" }\n')  # fmt: skip
    found = al.check(recording, file)
    assert (outcomes(found, "gx"), outcomes(found, "ax")) == ({"N": AGREES, "minimum": AGREES}, {"N": EXCEEDS})
    assert {row.outcome for row in al.check(recording, "adis16470").terms if row.quantity == "N"} == {EXCEEDS}


def markov(time, seed, drive=None):
    rng = np.random.default_rng(seed)
    phi = np.exp(-1 / (RATE * time))
    drive = rng.standard_normal if drive is None else drive(rng)
    return 1e-3 * lfilter([np.sqrt(1 - phi**2)], [1, -phi], drive(SIZE)) + 1e-3 * rng.standard_normal(SIZE)


SAME = "N 1.414214e-4 rad/s/sqrt(Hz), GM 1e-3 rad/s {} s; N 1 ug/sqrt(Hz), GM 1 ug 4 s"


@pytest.mark.slow("takes more than half a second")
def test_the_correlation_time_is_found():
    right, wrong = (
        al.Recording(tuple(al.Record(markov(time, i), RATE, "rad/s", name=name) for i, name in enumerate("xy")))
        for time in (20.0, 4.0)
    )
    assert al.check(right, SAME.format(20)).agrees
    found = al.check(wrong, SAME.format(40))
    (time,) = (row for row in found.terms if row.quantity == "T")
    assert (time.channel, time.outcome, time.claimed) == ("x, y", DIFFERS, 40.0)
    assert time.low < 0.1 < time.high
    cause = next(cause for cause in found.causes if cause.quantity == "T")
    assert cause.sentences == ("the correlation time of the other kind of sensor",)


@rows("draw, sentence", [
    (lambda rng, n: rng.random(n) - 0.5, "rand() instead of randn(): uniform over an interval of length 1"),
    (lambda rng, n: rng.random(n), "as that of rand() between 0 and 1"),
    (lambda rng, n: 2 * rng.random(n) - 1, "rand() instead of randn(): uniform from -1 to 1"),
    (lambda rng, n: 12**0.5 * (rng.random(n) - 0.5), "the samples are uniform: rand() instead of randn()"),
])  # fmt: skip
def test_uniform_numbers_are_found(draw, sentence):
    record = al.Record(1e-3 * draw(np.random.default_rng(4), SIZE), RATE, "rad/s", name="gx")
    found = al.check(record, f"N {1e-3 / RATE**0.5} rad/s/sqrt(Hz)")
    assert outcomes(found, "gx")["kurtosis"] == DIFFERS
    assert any(sentence in cause.words for cause in found.causes)


@pytest.mark.slow("takes more than half a second")
def test_a_bias_that_is_driven_by_rand_is_found():
    record = al.Record(markov(20.0, 5, lambda rng: rng.random), RATE, "rad/s", name="gx")
    found = al.check(record, SAME.format(20))
    assert any("driven by rand()" in cause.words for cause in found.causes)


def test_what_is_not_there_is_refused(recording):
    refused(al.DataError, "claims nothing of the channels", lambda: al.check(recording["ax"], "N 1 deg/sqrt(h)"))
    refused(al.UsageError, "tolerance must be", lambda: al.check(recording["ax"], "100 ug/sqrt(Hz)", tolerance=2.0))
    refused(al.UsageError, "no data sheet", lambda: al.check(recording["ax"], "nothing"))
