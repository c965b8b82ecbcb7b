"""What a comparison says beside the coefficients, and several runs: what they have in common, which lies apart."""

import json
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from tests.rows import refused, rows

import allanite as al
from allanite.comparison.change import told
from allanite.comparison.contrast import IntervalContrast
from allanite.comparison.ratio import sine
from allanite.comparison.runs import CommonValue, bartlett
from allanite.comparison.two_records import paired_homogeneity, paired_law, resemblance
from allanite.core.units import SIGNALS
from allanite.reporting import table
from allanite.reporting.words import change_of

RATE = 100.0
WHITE = al.N(1, "deg/sqrt(h)")
NB = al.N(0.3, "deg/sqrt(h)") + al.B(20, "deg/h")
MODEL = al.N(0.3, "deg/sqrt(h)") + al.K(300, "deg/h/sqrt(h)")


def simulated(seed, model=NB, n=16384):
    return al.simulate(model, n, RATE, rng=seed, name="gx")


def hum(size, frequency=12.0):
    return NB + al.Sine(size, "deg/h", frequency=frequency)


def lines(found):
    return [change for change in found.terms if change.frequency is not None]


@pytest.mark.slow("takes more than half a second")
def test_an_amplitude_that_grows_is_a_row_and_in_the_verdict():
    found = al.compare(simulated(1, hum(60)), simulated(2, hum(90)))
    (line,) = lines(found)
    assert (line.outcome, line.label) == ("larger", "Sine at 12 Hz")
    assert line.interval()[0] < 50 < line.interval()[1]
    assert found.pairs[0].changed
    assert "Sine at 12 Hz +" in found.verdict
    again = al.from_dict(json.loads(json.dumps(found.to_dict())))
    assert again.verdict == pickle.loads(pickle.dumps(found)).verdict == found.verdict
    (line,) = lines(al.compare(simulated(3, hum(90)), simulated(4, hum(90))))
    assert line.outcome == "no change"


@pytest.mark.slow("seconds of analyses")
@rows("order, outcome", [(1, "larger"), (-1, "smaller")])
def test_a_sinusoid_of_one_record_is_looked_for_in_the_other(order, outcome):
    found = al.compare(*[simulated(1), simulated(2, hum(90))][::order])
    (line,) = lines(found)
    assert (line.outcome, {line.before.status, line.after.status}) == (outcome, {"absent", "identified"})
    low, high = line.interval()
    assert low <= line.percent <= high
    assert order == 1 or "Sine at 12 Hz -100 % (-100 to -" in found.verdict
    assert found.pairs[0].changed
    # the sinusoids are taken out of the noise, and the curves have them
    assert "no change of the noise" not in found.verdict
    assert "the curves differ, most at 0.0" in found.verdict


def test_curves_that_differ_are_never_under_no_change():
    found = al.compare(simulated(5), simulated(6)).pairs[0]
    assert found.verdict.startswith("no change of the noise is detected")
    p = np.where(np.arange(found.ratios.p.size) == 3, 1e-4, found.ratios.p)
    differing = replace(found, ratios=replace(found.ratios, p=p))
    assert differing.changed
    assert "no change of the noise" not in differing.verdict
    assert f"the curves differ, most at {found.ratios.tau[3]:.4g} s" in differing.verdict
    some = replace(found, ratios=replace(found.ratios, p=np.where(p == 1e-4, 0.01, np.maximum(p, 0.1))))
    assert not some.changed  # 0.01 is nothing among fourteen


def test_limits_of_a_ratio_of_amplitudes():
    def against(first, second):
        return IntervalContrast(*(sine(v, 0.1, SIGNALS[0], 12.0, significant=v > 0.4) for v in (first, second)))

    contrast = against(2.0, 3.0)
    rng = np.random.default_rng(1)
    ratios = (3 + 0.1 * rng.standard_normal(100_000)) / (2 + 0.1 * rng.standard_normal(100_000))
    assert contrast.limits(0.95) == pytest.approx(np.quantile(ratios, [0.025, 0.975]), rel=0.01)
    # one that has gone: its change of -100 % belongs to the interval
    gone = against(2.0, 0.3)
    assert gone.limits(0.95) == (gone.ratio, pytest.approx(0.25, rel=0.1))
    low, high = against(0.1, 3.0).limits(0.95)
    assert 5 < low < 30
    assert high == np.inf


def correlated(seed, size=0.3):
    """Two records of the same noise, each with a little of its own."""
    rng = np.random.default_rng(seed)
    both = rng.standard_normal(4096)
    own = size * rng.standard_normal((2, 4096))
    return tuple(al.Record(both + part, RATE, "deg/h", name="gx") for part in own)


def test_pairs_of_one_noise_are_told_from_independent_records():
    raw = al.simulate(al.Model("N 0.1 deg/sqrt(h), K 5 deg/h/sqrt(h)"), 65536, 10.0, rng=1)
    smooth = raw.with_values(np.convolve(raw.values, np.full(5, 0.2), "same"), "smoothed")
    assert resemblance((raw, smooth)) > 0.9
    assert resemblance(correlated(1)) > 0.85
    assert resemblance((simulated(1), simulated(2))) < 0.1
    assert resemblance((simulated(1), simulated(1, n=8192))) == 0.0


@rows("drift", ["R 5 deg/h/s", "K 50 deg/h/sqrt(s)", "B 5 deg/s, R 5 deg/h/s"])
def test_records_that_only_drift_alike_are_no_pair(drift):
    model = al.Model(f"N 0.1 deg/sqrt(h), {drift}")
    for seed in range(10):
        pair = [al.simulate(model, 4096, 10.0, rng=np.random.default_rng([seed, i])) for i in range(2)]
        assert resemblance(pair) < 0.5


@pytest.mark.slow("ensemble")
def test_equal_members_of_a_pair_are_found_different_as_often_as_they_should():
    """In 200 pairs, at 5 %: 2 to 20."""
    pairs = [correlated(seed) for seed in range(200)]
    assert 2 <= sum(paired_homogeneity(pair).p <= 0.05 for pair in pairs) <= 20
    curves = [tuple(al.deviation(r, m=[1, 8], noise=WHITE) for r in pair) for pair in pairs]
    laws = [
        (paired_law(pair, curve), curve[1].variance / curve[0].variance)
        for pair, curve in zip(pairs, curves, strict=True)
    ]
    p = np.array([law.p(ratio) for law, ratio in laws])
    assert np.all((p <= 0.05).sum(axis=0) <= 20)
    assert np.all((p <= 0.5).sum(axis=0) >= 75)
    limits = [law.limits(ratio, 0.9) for law, ratio in laws]
    held = np.mean([(low <= 1) & (high >= 1) for low, high in limits], axis=0)
    assert np.all((held > 0.84) & (held < 0.96))


@pytest.mark.slow("takes more than half a second")
def test_raw_and_corrected_readings_are_compared_as_a_pair():
    """A little noise that independent records would hide, and that their difference shows."""
    both, own = np.random.default_rng(1).standard_normal((2, 4096))
    raw, corrected = (al.Record(y, RATE, "deg/h", name="gx") for y in (both + 0.2 * own, both))
    other = al.Record(np.random.default_rng(9).standard_normal(4096), RATE, "deg/h", name="gx")
    found, alone = al.compare(raw, corrected).pairs[0], al.compare(raw, other).pairs[0]
    assert (found.paired, alone.paired) == (True, False)
    assert found.p < 1e-6
    assert alone.p > 0.01
    assert "octaves of frequency" in found.verdict
    assert any("corrected samples" in alert for alert in found.alerts)


@pytest.mark.slow("takes more than half a second")
def test_the_length_that_would_do_hardly_depends_on_chance():
    """It was that of the estimates, of which some are nearly zero: from twice to thousands of times these records."""
    model = al.N(0.3, "deg/sqrt(h)") + al.B(3, "deg/h") + al.K(50, "deg/h/sqrt(h)") + al.R(3e3, "deg/h^2")
    changes = [al.compare(simulated(s, model, 4096), simulated(s + 50, model, 4096)).terms for s in range(5)]
    for symbol in "BKR":
        needed = [c.needed for found in changes for c in found if c.symbol == symbol and c.needed]
        assert max(needed) < 8 * min(needed)


def test_the_numbers_of_a_row_agree():
    """A change near zero is written as its interval is; beside a limit there is no number."""
    ramp = al.R(3e5, "deg/h^2")
    found = al.compare(simulated(1, NB + ramp), simulated(2, NB + ramp))["R"]
    small = replace(found, ratio=1 + 1.9e-7, limits=lambda level: (1 - 2.763e-3, 1 + 2.801e-3))
    assert change_of(small, 0.95) == ("+0.00 %", "-0.28 .. +0.28 %")
    gone = replace(found.after, value=None, status="absent")
    less = replace(found, symbol="B", ratio=0.19, after=gone, limits=lambda level: (0.0, 0.6), adjusted=0.01)
    assert (change_of(less, 0.95), told(less)) == (("-", "below -40 %"), "B is detected only in the first record")


@pytest.mark.slow("ensemble")
def test_a_length_that_would_do_is_named_and_does():
    change = al.compare(simulated(1, MODEL, 2048), simulated(2, MODEL, 2048))["K"]
    assert change.outcome == "not resolvable"
    assert 2048 / RATE < change.needed < 3600
    # a walk as large as its limit, and half of it
    limit = max(e.upper for e in (change.before, change.after))
    models = [al.N(0.3, "deg/sqrt(h)") + al.Term("K", size, change.signal) for size in (limit, limit / 2)]
    n = round(change.needed * RATE)

    def detected(size):
        pairs = ([simulated(10 * i + j, model, size) for j, model in enumerate(models)] for i in range(1, 5))
        return sum(al.compare(*pair)["K"].p < 0.05 for pair in pairs)

    assert detected(n) >= 3
    assert detected(n // 8) <= 1


def test_reading_both_files_is_told(tmp_path):
    said, paths = [], [tmp_path / "before.csv", tmp_path / "after.csv"]
    for seed, path in enumerate(paths):
        al.write(simulated(seed, al.N(0.3, "deg/sqrt(h)"), 4096), path)
    al.compare(*paths, al.Recipe(terms="N"), progress=lambda what, share: said.append((what, share)))
    assert (said[0], [what for what, _ in said].count("reading"), said[-1][1]) == (("reading", 0.0), 2, 1.0)


def run(seed, n=4096, factor=1.0, rate=100.0):
    record = al.simulate(MODEL, n, rate, rng=seed, name="z")
    return replace(record, values=record.values * factor)


@pytest.mark.slow("seconds of analyses")
def test_equal_runs_have_one_noise_and_their_degrees_of_freedom_add_up():
    equal = al.comparison.pool([run(seed) for seed in range(1, 6)])
    channel = equal["z"]
    assert channel.alike
    assert not channel.apart
    assert "one noise model describes all 5 runs" in equal.verdict
    low, high = channel["N"].interval()
    assert low < MODEL["N"].value < high
    least, most = al.identify(run(1))["N"].interval()
    assert high - low < 0.7 * (most - least)
    assert 0.2 < channel["N"].between / channel["N"].within < 2.5
    np.testing.assert_allclose(channel.curve.edf, np.sum([curve.edf for curve in channel.curves], axis=0))
    variance = np.array([curve.variance for curve in channel.curves])
    assert np.all((channel.curve.variance > variance.min(axis=0)) & (channel.curve.variance < variance.max(axis=0)))
    narrow, wide = (np.divide(*curve.interval()[::-1]) for curve in (channel.curve, channel.curves[0]))
    assert np.all(narrow < wide)
    assert (channel.p > 0.001).all()


@rows(("factor", "alike"), [(1.0, True), (1.2, False)])
def test_two_runs_have_common_coefficients_and_a_test_but_hardly_a_scatter(factor, alike):
    pair = [run(1), run(2, n=8192, factor=factor)]
    channel = al.comparison.pool(pair)["z"]
    assert channel.alike is alike
    assert not channel.apart
    n = channel["N"]
    assert n.dof == 1
    assert (n.adjusted > 0.05) is alike
    low, high = n.interval()
    first, second = (al.identify(one)["N"] for one in pair)
    assert first.value < n.value < second.value or second.value < n.value < first.value
    assert (high - low < np.subtract(*second.interval()[::-1])) is np.bool_(alike)
    assert alike or (low < first.value < high and low < second.value < high)
    least, most = 1 / stats.chi2.isf([0.025, 0.975], 1) ** 0.5
    assert f"{least:.2f} to {most:.2g} times" in channel.alerts[-1]


@pytest.mark.slow("takes more than half a second")
def test_the_run_that_lies_apart_is_named_and_two_do_not_hide_each_other():
    found = al.comparison.pool([run(1), run(2), run(3, factor=1.3), run(4)])
    channel = found["z"]
    assert (list(channel.apart), channel.alike) == (["run 3"], False)
    assert channel.rest > 0.05
    assert "different from the others: run 3" in found.verdict
    assert channel["N"].adjusted < 1e-6
    assert channel["N"].between > 3 * channel["N"].within
    assert channel.p[0] < 1e-6
    two = al.comparison.pool([run(1), run(2, factor=1.5), run(3), run(4, factor=0.7), run(5)])["z"]
    assert set(two.apart) == {"run 2", "run 4"}


@pytest.mark.slow("takes more than half a second")
def test_ramps_that_differ_are_named():
    """Each run has a ramp of its own, which no noise model contains."""
    ramps = [al.R(size, "deg/h^2") for size in (5e5, -2e5, 5e5)]
    runs = [al.simulate(MODEL + ramp, 4096, 100.0, rng=seed) for seed, ramp in enumerate(ramps, 1)]
    found = al.comparison.pool(runs)
    (channel,) = found.channels
    assert channel.test.p > 0.05
    assert not channel.alike
    assert "the scatter between runs exceeds that within them in R" in found.verdict
    assert channel["R"].adjusted < 1e-3
    assert [np.sign(e.value) for e in channel["R"].runs] == [1, -1, 1]
    assert re.search(r"^ +R  +rate ramp ", table(found), re.MULTILINE)
    assert al.from_dict(found.to_dict()).verdict == found.verdict
    alike = al.comparison.pool([runs[0], runs[2], replace(runs[0], values=runs[2].values[::-1] * -1.0)]).terms[-1]
    low, high = alike.interval()
    assert alike.adjusted > 0.05
    assert low < ramps[0].value < high


@pytest.mark.slow("takes more than half a second")
def test_runs_of_unlike_lengths_and_rates():
    found = al.comparison.pool([run(1), run(2, n=9000), run(3, n=8192, rate=200.0)])["z"]
    assert found.band[1] == 50.0
    assert found.alike


@rows(("values", "within", "between"), [
    ((1.0, 2.0, 6.0), 1e-9, True), ((1.0, 2.0, 6.0), 0.5, True), ((1.0, 2.0, 3.0), 10.0, False), ((1.0, 9.0), 1.0, True)
])  # fmt: skip
def test_limits_of_runs_that_scatter_are_those_of_student(values, within, between):
    n, mean, error = len(values), float(np.mean(values)), within / len(values) ** 0.5
    common = CommonValue(np.array(values), np.full(n, within), mean, stats.norm(mean, error).interval)
    low, high = stats.t(n - 1, mean, stats.sem(values)).interval(0.95)
    assert bool(common.between) is between
    assert common.value == pytest.approx(mean)
    assert common.limits(0.95) == pytest.approx((low, high) if between else stats.norm(mean, error).interval(0.95))


def test_bartlett_is_scipys():
    samples = np.random.default_rng(1).standard_normal((4, 12))
    wanted = stats.bartlett(*samples).pvalue
    variance = samples.var(axis=1, ddof=1)[:, None]
    assert bartlett(variance, np.full((4, 1), 11.0))[0] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_the_beginning_of_a_record_agrees_with_the_whole():
    found = al.comparison.truncation(run(7, n=12_000), 60.0)
    (pair,) = found.pairs
    low, high = pair.whole["N"].interval()
    assert not pair.changed
    assert low < MODEL["N"].value < high
    assert found.names == ("first 60 s", "rest")
    louder = run(7, n=12_000)
    louder.values[6000:] *= 1.4
    assert al.comparison.truncation(louder, 60.0)["N"].outcome == "larger"
    refused(al.UsageError, "500", lambda: al.comparison.truncation(run(1), 500.0))


@pytest.mark.slow("takes more than half a second")
def test_what_cannot_be_pooled():
    refused(al.UsageError, "at least two runs, not 1", lambda: al.comparison.pool([run(1)]))
    refused(al.DataError, "identical samples", lambda: al.comparison.pool([run(1), run(2), run(1)]))
    other = al.Record(np.random.default_rng(1).standard_normal(4096), 100.0, "m/s^2", name="z")
    refused(al.DataError, "one type", lambda: al.comparison.pool([run(1), run(2), other]))
    pairs = [al.Recording(tuple(replace(run(i), name=name) for i, name in enumerate(names))) for names in ("xy", "uv")]
    refused(al.UsageError, "no channel in common", lambda: al.comparison.pool([*pairs, run(3)]))
    refused(al.UsageError, "unknown channel 'q'", lambda: al.comparison.pool([run(1), run(2), run(3)])["q"])
