"""Two records: the joint likelihood, the ratio of variances, the verdict, and what is refused."""

import math
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.stats import f as fisher
from tests.rows import refused, rows

import allanite as al
from allanite.comparison.change import holm
from allanite.comparison.common_likelihood import drawn, joint, reduced, tied
from allanite.comparison.contrast import Contrast, IntervalContrast, gain, homogeneity
from allanite.comparison.ratio import RampContrast, RatioLaw, ratio_law, shared_factors
from allanite.core.estimate import Estimate
from allanite.core.limits import Below, NormalMixture
from allanite.core.units import SIGNALS
from allanite.statistics.confidence.limits import mixtures
from allanite.statistics.table import CurvePoints, statistic_named

RATE = 100.0
NK = al.N(0.3, "deg/sqrt(h)") + al.K(300, "deg/h/sqrt(h)")
QNBK = al.Q(2, "arcsec") + al.N(0.3, "deg/sqrt(h)") + al.B(20, "deg/h") + al.K(500, "deg/h/sqrt(h)")


def simulated(model, seed, n=4096, rate=RATE, name="z"):
    return al.simulate(model, n, rate, rng=seed, name=name)


def scaled(record, factor):
    return replace(record, values=record.values * factor)


@pytest.fixture(scope="module")
def pair():
    return simulated(QNBK, 1), simulated(QNBK, 2, n=8192)


def test_likelihoods_of_records_add_and_hypotheses_cost(pair):
    both = joint(pair, "QNBKR")
    for theta in (both.chosen.theta + 1e-3 * both.chosen.theta.max(), both.chosen.theta * 1.7 + 1e-12):
        parts = sum(part.value(theta) for part in both.parts)
        assert tied(both.parts).value(theta) == pytest.approx(parts, rel=1e-12)
    # a hypothesis is never better than its separate models
    for i in range(len(both.symbols)):
        contrast = Contrast(both, i)
        at = [contrast.excess(phi) for phi in (0.2, math.pi / 4, 1.2)]
        assert min(at) >= 0
        if 0 < contrast.ratio < math.inf:
            assert contrast.excess(math.atan(contrast.ratio)) == pytest.approx(0, abs=1e-3)
    # terms that are not there take no direction with them
    only_n = np.array([s == "N" for s in both.symbols])
    part = reduced(both.parts[0], only_n)
    theta = np.array([both.chosen.theta[1]])
    assert part.flat.tolist() == [True]
    assert part.value(theta) == pytest.approx(both.parts[0].value(np.where(only_n, both.chosen.theta, 0.0)), rel=1e-9)


def test_drawn_powers_have_the_likelihoods_own_law(pair):
    """Mean of 400 draws of each bin within 5 standard errors, and the gradient at the truth is zero on average."""
    both, rng = joint(pair, "QNBKR"), np.random.default_rng(1)
    part, theta = both.parts[0], both.chosen.theta
    draws = [drawn(part, theta, rng) for _ in range(400)]
    edge = (np.einsum("bii->bi", part.UU)[:, ~part.flat] @ (part.W @ theta)[~part.flat]) / part.count
    mean = np.mean([draw.power for draw in draws], axis=0)
    assert np.abs((mean / (part.expectation(theta) + edge) - 1) / np.sqrt(2 / part.count / 400)).max() < 5
    slopes = np.array([draw.gradient(theta) for draw in draws])
    assert np.abs(slopes.mean(axis=0) / (slopes.std(axis=0) / 20)).max() < 4.5


@pytest.mark.slow("takes more than half a second")
def test_draws_gain_what_simulated_pairs_gain():
    """Mean of the likelihood ratio over 150 pairs and 150 draws: within 4 standard errors."""
    real = []
    for seed in range(1, 151):
        both = joint([simulated(NK, 2 * seed, n=1024), simulated(NK, 2 * seed + 1, n=1024)], "NKR")
        real.append(gain(both.parts, both.chosen.theta))
    rng, theta = np.random.default_rng(1), both.fitted[-1].theta
    made = [gain(tuple(drawn(part, theta, rng) for part in both.parts), theta) for _ in range(150)]
    error = math.sqrt((np.var(real) + np.var(made)) / 150)
    assert abs(np.mean(real) - np.mean(made)) < 4 * error


def test_the_bootstrap_stops_early_only_where_chance_is_likely(pair):
    tests = []
    for seed in range(1, 21, 2):
        both = joint([simulated(NK, seed), simulated(NK, seed + 1)], "QNBKR")
        tests.append(homogeneity(both, np.random.default_rng(seed)))
    assert sum(test.p <= 0.05 for test in tests) <= 4  # error probability 6e-5
    assert all(10 <= test.draws <= 199 for test in tests if test.p > 1e-4)
    assert any(test.draws < 60 for test in tests)
    louder = homogeneity(joint([pair[0], scaled(pair[1], 1.5)], "QNBKR"), np.random.default_rng(1))
    assert (louder.draws, louder.p < 1e-12) == (0, True)


@rows("symbol", "NK")
def test_exchanged_and_scaled_records_have_exchanged_and_scaled_ratios(symbol):
    a, b = simulated(NK, 1), simulated(NK, 2)
    i = "QNBK".index(symbol)
    there, back, louder = (Contrast(joint(p, "QNBKR"), i) for p in ((a, b), (b, a), (a, scaled(b, 1.3))))
    low, high = there.limits(0.95)
    assert (back.ratio, back.p) == (pytest.approx(1 / there.ratio, rel=1e-3), pytest.approx(there.p, rel=1e-2))
    assert sorted(1 / v if v else math.inf for v in back.limits(0.95)) == pytest.approx([low, high], rel=2e-3)
    # what the common model holds may change with the size; the limits of what it does hold scale
    assert louder.ratio == pytest.approx(1.3 * there.ratio, rel=1e-2)


def single(edf):
    row = statistic_named("oadev")
    law = mixtures(CurvePoints(row, np.array([1]), [(100, 1)], 100, 1.0, 0.2), [al.Model((al.N(1, "rad/sqrt(s)"),))])[1]
    weight, dof = np.zeros_like(law.weight), np.ones_like(law.dof)
    weight[0, 0], dof[0, 0] = 1 / edf, edf
    return law._replace(weight=weight, dof=dof)


@rows("first", [8.0, 50.0, 4000.0])
@rows("second", [12.0, 900.0])
def test_the_ratio_of_two_chi_squares_is_fishers_f(first, second):
    law = RatioLaw(single(first), single(second), (np.array([first]), np.array([second])))
    for p in (0.025, 0.3, 0.975):
        wanted = fisher.ppf(p, second, first)
        assert law.below(np.array([wanted]))[0] == pytest.approx(p, abs=1e-3)
        assert law.quantile(p)[0] == pytest.approx(wanted, rel=0.01)


@pytest.mark.slow("takes more than half a second")
def test_the_ratio_at_few_degrees_of_freedom():
    """Shares of 800 equal pairs below the 2.5, 50 and 97.5 % points, at all octaves: 4.5 standard errors."""
    record = simulated(NK, 1, n=512)
    m = shared_factors([record, record], "oadev", "octave")
    law = ratio_law((record, record), "oadev", m, [NK, NK])
    rng = np.random.default_rng(1)
    variance = np.array([
        al.deviation(al.simulate(NK, 512, RATE, rng=rng), "oadev", m=m[0].tolist(), noise=None).variance
        for _ in range(1600)
    ])  # fmt: skip
    ratio = variance[::2] / variance[1::2]
    for p in (0.025, 0.5, 0.975):
        share = (ratio < law.quantile(p)).mean(axis=0)
        assert np.abs(share - p).max() < 4.5 * math.sqrt(p * (1 - p) / 800) + 0.006


def test_averaging_times_of_unlike_rates():
    a, b = simulated(NK, 1, rate=99.87), simulated(NK, 2, n=5000)
    first, second = shared_factors([a, b], "oadev", "octave")
    np.testing.assert_allclose(first / 99.87, second / 100.0, rtol=0.005)
    short = [simulated(NK, 1, n=100), simulated(NK, 2, n=300, rate=0.5)]
    refused(al.DataError, "no averaging time in common", lambda: shared_factors(short, "oadev", "octave"))
    refused(al.UsageError, "oadev, ohdev", lambda: shared_factors([a, b], "mtie", "octave"))


def test_a_change_is_found_and_named():
    found = al.compare(simulated(NK, 1), scaled(simulated(NK, 2), 0.8))
    low, high = found["N"].interval()
    assert (found["N"].outcome, found["N"].significant, found["B"].outcome) == ("smaller", True, "not resolvable")
    assert low < -20 < high < 0
    assert re.search(r"N -.*not resolvable in these records, .*: Q \(at \S+ min or more\), B \(at", found.verdict)
    assert found.pairs[0].ratios.p[0] < 1e-6
    assert found.pairs[0].ratios.interval()[1][0] < 1


def test_a_ramp_keeps_its_sign():
    up, down, again = (simulated(NK + al.R(size, "deg/h^2"), i) for i, size in enumerate((3e4, -3e4, 3e4), 1))
    turned, same = al.compare(up, down)["R"], al.compare(up, again)["R"]
    assert (turned.significant, same.significant) == (True, False)
    assert turned.ratio < 0
    assert turned.limits(0.95)[0] < -1 < turned.limits(0.95)[1] < 0
    assert same.limits(0.95)[0] < 1 < same.limits(0.95)[1]


@rows("level", [1e-4, 0.01, 0.5, 0.95])
def test_limits_of_a_ratio_of_ramps_hold_the_share_that_they_state(level):
    # the mean of this mixture lies beside its median
    first, second = (NormalMixture(*map(np.array, of)) for of in (
        ([-2.0, 2.6], [0.01, 0.4], [0.99, 0.01]), ([1.0, 4.0], [0.02, 0.1], [0.7, 0.3]),
    ))  # fmt: skip
    low, high = RampContrast(first, second).limits(level)
    assert [first.below(first.quantile(p)) for p in (1e-6, 0.3, level)] == pytest.approx([1e-6, 0.3, level], rel=1e-9)
    shares = sorted(second.minus(first, ratio).below(0.0) for ratio in (low, high))
    assert low < high
    assert shares == pytest.approx([(1 - level) / 2, (1 + level) / 2], abs=1e-5)


def test_gauss_markov_noise_is_compared_with_its_time_constant():
    model = al.N(0.3, "deg/sqrt(h)") + al.GM(60, "deg/h", time_constant=5.0)
    found = al.compare(simulated(model, 1, n=40_000), scaled(simulated(model, 2, n=40_000), 2.0))
    assert (found["GM"].outcome, found["B"].outcome) == ("larger", "not resolvable")
    assert found["GM"].interval()[0] < 100 < found["GM"].interval()[1]
    (time,) = (change for change in found.terms if change.parameter)
    assert (time.label, time.unit, time.sizes) == ("GM time constant", "s", [f["GM"].shape[0] for f in found[0].fits])
    assert time.percent == pytest.approx(100 * (time.sizes[1] / time.sizes[0] - 1))
    assert time.interval()[0] < 0 < time.interval()[1]
    assert any("GM has one shape in the common model" in alert for alert in found.pairs[0].alerts)


SHAPED = {
    "GM": al.GM(100, "deg/h", time_constant=2.0), "GML": al.GML(100, "deg/h", time_constant=4.0),
    "GMA": al.GMA(20, "arcsec", time_constant=0.2), "GM2": al.GM2(100, "deg/h", frequency=0.7, damping=0.3),
}  # fmt: skip


@pytest.mark.slow("seconds of analyses")
@rows("first, second", combinations(SHAPED, 2))
def test_terms_with_shapes_of_any_kind_are_compared(first, second):
    white = al.N(0.3, "deg/sqrt(h)")
    one, two = (simulated(white + SHAPED[s], seed) for seed, s in enumerate((first, second)))
    terms = ",".join(dict.fromkeys(("N", first, second)))
    found = al.compare(one, two, terms=terms).pairs[0]
    assert found.refusal == ""
    assert found.changed or {first, second} == {"GM", "GML"}
    for e in (e for fit in found.fits for e in fit if e.shape):
        assert any(f"{e.symbol} has one shape in the common model" in alert for alert in found.alerts)


@pytest.mark.slow("seconds of analyses")
def test_a_damped_oscillation_is_pooled_and_held_against_its_beginning():
    model = al.N(0.3, "deg/sqrt(h)") + SHAPED["GM2"]
    runs = [simulated(model, seed, n=8000) for seed in range(3)]
    pooled = al.comparison.pool(runs, terms="N,GM,GM2").channels[0]
    low, high = next(term for term in pooled.terms if term.symbol == "GM2").limits(0.95)
    assert low < model["GM2"].value < high
    labels = [change.label for change in al.compare(*runs[:2]).terms]
    assert {"GM2", "GM2 natural frequency", "GM2 damping ratio"} <= set(labels)  # although it was not asked for
    part = al.comparison.truncation(runs[0], 40.0, al.Recipe(terms="N,GM2")).pairs[0]
    assert part["GM2"].limits(0.99)[0] < 1 < part["GM2"].limits(0.99)[1]


@pytest.mark.slow("takes more than half a second")
def test_sinusoids_are_taken_out_of_the_comparison():
    strong, weak = (NK + al.Sine(size, "deg/h", frequency=7.3) for size in (200.0, 80.0))
    found, wanted = (
        al.compare(simulated(before, 1, n=20_000), simulated(after, 2, n=20_000)).pairs[0]
        for before, after in ((strong, weak), (NK, NK))
    )
    assert found.test.statistic == pytest.approx(wanted.test.statistic, abs=0.1)
    assert found["N"].interval() == pytest.approx(wanted["N"].interval(), abs=0.05)
    assert sum("sinusoids were removed, at 7.3" in alert for alert in found.alerts) == 2


@pytest.mark.slow("takes more than half a second")
def test_lost_readings_and_outliers_change_nothing():
    one, two = simulated(NK, 1), simulated(NK, 2)
    spikes, lost = one.values.copy(), two.values.copy()
    spikes[[700, 2100]] += 0.02
    lost[1000:1100] = np.nan
    found = al.compare(replace(one, values=spikes), replace(two, values=lost))
    assert found["N"].interval() == pytest.approx(al.compare(one, two)["N"].interval(), abs=1.0)
    assert not found.pairs[0].changed
    assert any("2 outliers" in alert for alert in found.pairs[0].alerts)
    kept = al.compare(replace(one, values=spikes), two, al.Recipe(taus="octave", outliers="keep"))
    assert kept["N"].outcome == "smaller"


@pytest.mark.slow("takes more than half a second")
def test_fits_alone_say_nearly_the_same_of_strong_terms():
    records = [simulated(NK, 1, n=8192), scaled(simulated(NK, 2, n=8192), 1.1)]
    whole, fits = al.compare(*records), al.compare(*map(al.identify, records))
    assert fits["N"].interval() == pytest.approx(whole["N"].interval(), abs=2.0)
    assert fits["N"].outcome == whole["N"].outcome == "larger"
    assert (fits["Q"].outcome, fits.pairs[0].test) == ("not resolvable", None)
    squares = [al.identify(record, "ls") for record in records]
    refused(al.UsageError, "no intervals", lambda: al.compare(*squares))


def test_holm():
    assert holm([0.01, 0.02, 0.03, 0.5]) == pytest.approx([0.04, 0.06, 0.06, 0.5])
    assert (holm([0.9, 0.8]), holm([])) == ([1.0, 1.0], [])


@pytest.mark.slow("takes more than half a second")
def test_the_same_records_have_the_same_verdict(pair):
    assert al.compare(*pair).to_dict() == al.compare(*pair).to_dict()


@pytest.mark.slow("takes more than half a second")
def test_channels_are_paired_by_name_or_in_order():
    x, y, u, v = (simulated(NK, seed, name=name) for seed, name in enumerate("xyuv", 1))
    by_name = al.compare(al.Recording((x, y)), al.Recording((replace(u, name="y"), replace(v, name="w"))))
    assert [pair.name for pair in by_name] == ["y"]
    assert "not compared: w, x" in by_name.notes[-1]
    in_order = al.compare(al.Recording((x, y)), al.Recording((u, v)))
    assert [pair.name for pair in in_order] == ["x / u", "y / v"]
    assert (in_order["x / u"]["N"].outcome, in_order.verdict.count("\n")) == ("no change", 1)
    refused(al.UsageError, "cannot be paired", lambda: al.compare(al.Recording((x, y)), u))
    assert al.compare(al.analyze(x), u).pairs[0].test.p == al.compare(x, u).pairs[0].test.p


def noisy(n=4000, rate=RATE, unit="deg/s", seed=1, name="z"):
    return al.Record(np.random.default_rng(seed).standard_normal(n), rate, unit, name=name)


@rows("other, words", [
    (noisy(unit="m/s^2", name="ax", seed=2), ["gyro", "accelerometer", "one type"]),
    (al.Record(np.full(4000, 2.5), RATE, "deg/s"), ["record 2"]), (noisy(n=150), ["150 samples", "at least 200"]),
    (noisy(rate=0.001, seed=2), ["no frequency band in common", "record longer"]), (noisy(), ["identical samples"]),
])  # fmt: skip
def test_what_cannot_be_compared(other, words):
    refused(al.DataError, "(?s)" + "".join(f"(?=.*{word})" for word in words), lambda: al.compare(noisy(), other))


def test_wrong_usage():
    refused(al.UsageError, "'whittle', not 'ls'", lambda: al.compare(noisy(), noisy(seed=2), al.Recipe(method="ls")))
    refused(al.UsageError, "takes a record or samples, not 3", lambda: al.compare(noisy(), 3))
    refused(al.UsageError, "only be compared with a fit", lambda: al.compare(noisy(), al.identify(noisy(seed=2))))
    refused(al.UsageError, "'Z' was not compared", lambda: al.compare(noisy(), noisy(seed=2))["Z"])
    refused(al.UsageError, "between 0 and 1", lambda: al.compare(noisy(), noisy(seed=2))["N"].interval(2))


def test_a_fit_with_a_term_that_the_other_lacks():
    absent = Estimate("K", SIGNALS[0], None, None, "absent", 1e-6, "gls", Below(lambda level: max(level - 0.5, 0.0)))
    there = replace(absent, value=2.0, status="identified", limits=lambda level: (2 - level, 2 + level))
    contrast = IntervalContrast(absent, there)
    assert contrast.limits(0.4) == (math.inf, math.inf)
    assert contrast.limits(0.9) == (pytest.approx(1.1 / 0.4), math.inf)
    assert 0 < contrast.p < 0.05


@pytest.mark.slow("takes more than half a second")
def test_records_of_unequal_length_share_noise_of_a_few_samples():
    model = al.N(0.5, "deg/sqrt(h)") + al.GM(0.1, "deg/s", time_constant=2.0)
    (channel,) = al.compare(*(simulated(model, n, n, 10.0) for n in (2**14, 2**13))).channels
    assert {"N", "GM"} <= {change.symbol for change in channel.changes}
    assert channel.p > 1e-3


def test_times_at_which_a_curve_is_zero_have_no_ratio():
    records = [al.Record(k * (np.arange(250) % 2.0), 100.0, "deg/s", name="gx") for k in (1, 1.5)]
    (pair,) = al.compare(*records)
    assert pair.ratios.ratio == pytest.approx(2.25)
    refused(al.AllaniteError, r"zero at 0\.02 s", lambda: al.compare(*records, taus=[0.02, 0.03]))
