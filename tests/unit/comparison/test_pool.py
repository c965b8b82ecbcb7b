"""Several runs: what they have in common, which lies apart; a part against the whole."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from tests.rows import refused, rows

import allanite as al
from allanite.comparison.pooled import bartlett
from allanite.reporting import table

MODEL = al.N(0.3, "deg/sqrt(h)") + al.K(300, "deg/h/sqrt(h)")


def run(seed, n=4096, factor=1.0, rate=100.0):
    record = al.simulate(MODEL, n, rate, rng=np.random.default_rng(seed), name="z")
    return replace(record, values=record.values * factor)


@pytest.fixture(scope="module")
def equal():
    return al.pool([run(seed) for seed in range(1, 6)])


@pytest.mark.slow("takes more than half a second")
def test_equal_runs_have_one_noise(equal):
    channel = equal["z"]
    assert channel.alike
    assert not channel.apart
    assert "one noise model describes all 5 runs" in equal.verdict
    low, high = channel["N"].interval()
    assert low < MODEL["N"].value < high
    one = al.identify(run(1))["N"].interval()
    assert high - low < 0.7 * (one[1] - one[0])
    assert 0.2 < channel["N"].between / channel["N"].within < 2.5


@rows(("factor", "alike"), [(1.0, True), (1.2, False)])
def test_two_runs_have_common_coefficients_and_a_test_but_hardly_a_scatter(factor, alike):
    pair = [run(1), run(2, n=8192, factor=factor)]
    channel = al.pool(pair)["z"]
    assert channel.alike is alike
    assert not channel.apart
    n = channel["N"]
    assert n.dof == 1
    assert (n.adjusted > 0.05) is alike
    low, high = n.interval()
    first, second = (al.identify(one)["N"] for one in pair)
    assert first.value < n.value < second.value or second.value < n.value < first.value
    assert high - low < np.subtract(*second.interval()[::-1])
    assert (
        f"{1 / stats.chi2.isf(0.025, 1) ** 0.5:.2f} to {1 / stats.chi2.isf(0.975, 1) ** 0.5:.2g} times"
        in channel.alerts[-1]
    )


@pytest.mark.slow("seconds of analyses")
def test_degrees_of_freedom_add_up(equal):
    channel = equal["z"]
    np.testing.assert_allclose(channel.curve.edf, np.sum([curve.edf for curve in channel.curves], axis=0))
    variance = np.array([curve.variance for curve in channel.curves])
    assert np.all((channel.curve.variance > variance.min(axis=0)) & (channel.curve.variance < variance.max(axis=0)))
    narrow, wide = (np.divide(*curve.interval()[::-1]) for curve in (channel.curve, channel.curves[0]))
    assert np.all(narrow < wide)
    assert (channel.p > 0.001).all()


@pytest.mark.slow("takes more than half a second")
def test_the_run_that_lies_apart_is_named():
    found = al.pool([run(1), run(2), run(3, factor=1.3), run(4)])
    channel = found["z"]
    assert list(channel.apart) == ["run 3"]
    assert channel.rest > 0.05
    assert not channel.alike
    assert "different from the others: run 3" in found.verdict
    assert channel["N"].adjusted < 1e-6
    assert channel["N"].between > 3 * channel["N"].within
    assert channel.p[0] < 1e-6


@pytest.mark.slow("takes more than half a second")
def test_ramps_that_differ_are_named():
    """Each run has a ramp of its own, which no noise model contains."""
    ramps = [al.R(size, "deg/h^2") for size in (5e5, -2e5, 5e5)]
    runs = [
        al.simulate(MODEL + ramp, 4096, 100.0, rng=np.random.default_rng(seed)) for seed, ramp in enumerate(ramps, 1)
    ]
    found = al.pool(runs)
    (channel,) = found.channels
    assert channel.test.p > 0.05
    assert not channel.alike
    assert "the scatter between runs exceeds that within them in R" in found.verdict
    ramp = channel["R"]
    assert ramp.adjusted < 1e-3
    assert [np.sign(e.value) for e in ramp.runs] == [1, -1, 1]
    assert re.search(r"^ +R  +rate ramp ", table(found), re.MULTILINE)
    assert al.from_dict(found.to_dict()).verdict == found.verdict
    alike = al.pool([runs[0], runs[2], replace(runs[0], values=runs[2].values[::-1] * -1.0)]).terms[-1]
    low, high = alike.interval()
    assert alike.adjusted > 0.05
    assert low < ramps[0].value < high


@pytest.mark.slow("takes more than half a second")
def test_two_that_lie_apart_do_not_hide_each_other():
    found = al.pool([run(1), run(2, factor=1.5), run(3), run(4, factor=0.7), run(5)])["z"]
    assert set(found.apart) == {"run 2", "run 4"}


@pytest.mark.slow("takes more than half a second")
def test_runs_of_unlike_lengths_and_rates():
    found = al.pool([run(1), run(2, n=9000), run(3, n=8192, rate=200.0)])["z"]
    assert found.band[1] == 50.0
    assert found.alike


def test_bartlett_is_scipys():
    samples = np.random.default_rng(1).standard_normal((4, 12))
    wanted = stats.bartlett(*samples).pvalue
    variance = samples.var(axis=1, ddof=1)[:, None]
    assert bartlett(variance, np.full((4, 1), 11.0))[0] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_the_beginning_of_a_record_agrees_with_the_whole():
    found = al.truncation(run(7, n=12_000), 60.0)
    (pair,) = found.pairs
    assert not pair.changed
    assert pair.whole["N"].interval()[0] < MODEL["N"].value < pair.whole["N"].interval()[1]
    assert found.names == ("first 60 s", "rest")
    louder = run(7, n=12_000)
    louder.values[6000:] *= 1.4
    assert al.truncation(louder, 60.0)["N"].outcome == "larger"
    refused(al.UsageError, "500", lambda: al.truncation(run(1), 500.0))


@pytest.mark.slow("takes more than half a second")
def test_what_cannot_be_pooled():
    refused(al.UsageError, "at least two runs, not 1", lambda: al.pool([run(1)]))
    refused(al.DataError, "identical samples", lambda: al.pool([run(1), run(2), run(1)]))
    other = al.Record(np.random.default_rng(1).standard_normal(4096), 100.0, "m/s^2", name="z")
    refused(al.DataError, "one type", lambda: al.pool([run(1), run(2), other]))
    x, y = (replace(run(seed), name=name) for seed, name in ((1, "x"), (2, "y")))
    with pytest.raises(al.UsageError, match="no channel in common"):
        al.pool([al.Recording((x, y)), al.Recording((replace(x, name="u"), replace(y, name="v"))), run(3)])
    refused(al.UsageError, "unknown channel 'q'", lambda: al.pool([run(1), run(2), run(3)])["q"])
