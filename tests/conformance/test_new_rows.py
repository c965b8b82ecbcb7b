"""A new statistic or noise term is one file and a line in its table: everything else follows from the row."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests import ROOT
from tests.commands import ends, run
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.model import term
from allanite.core.syntax import written
from allanite.core.units import SIGNALS, unit_of
from allanite.reporting import page
from allanite.statistics import covariance, edf
from allanite.statistics.confidence.powerlaw import symbol_of
from allanite.statistics.row import Statistic, constant
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

sys.path.append(str(ROOT / "tests" / "plugin"))
from allanite_sample.fourth import FDEV
from allanite_sample.relaxation import relaxation


def _triangular(m):
    """A window: the rate of its second half less that of its first, both with triangular weights."""
    rise = np.minimum(np.arange(1, m + 1), np.arange(m, 0, -1)).astype(float)
    rates = np.concatenate((-rise, rise)) * (m / rise.sum())
    return np.ones(1), (np.append(0.0, rates) - np.append(rates, 0.0))[None, :]


def _triangular_sums(x, m):
    return np.array([np.sum(np.convolve(x, _triangular(s)[1][0][::-1], "valid") ** 2) for s in m.tolist()])


WDEV = Statistic(
    name="wdev", title="triangular deviation", formula="x", reference="this test", meaning="Change of a mean.",
    use="Here.", limits="None.", cost="Little.",
    order=2, norm=constant(2.0), span=(2, 0), sums=_triangular_sums, window=_triangular,
)  # fmt: skip

# ... and flicker of the angle, under another name and colour

PLAIN_FLICKER = replace(
    TERMS["F"], symbol="Z", title="wander of the angle", meaning="flicker of the rate's integral",
    reference="this test", titles={}, color="#123456",
)  # fmt: skip

MODEL = "Z 3 arcsec, N 0.01 deg/sqrt(h)"
WALK = al.N(0.1, "deg/sqrt(h)") + al.K(5.0, "deg/h/sqrt(h)")


@pytest.fixture(autouse=True)
def new_rows():
    """One line a row."""
    with (STATISTICS.trying("fdev", FDEV), STATISTICS.trying("wdev", WDEV), TERMS.trying("Z", PLAIN_FLICKER),
          TERMS.trying("RR", relaxation(1.0))):  # fmt: skip
        yield


def simulated(model, n=2**13, seed=1):
    return al.simulate(model, n, 1.0, rng=np.random.default_rng(seed), name="z")


def as_expected(model, name):
    """Mean and scatter of 60 records, within 5 standard errors of what the row leads one to expect."""
    curves = [al.deviation(simulated(model, 2048, seed), name, m=[1, 8, 64], noise=None) for seed in range(60)]
    V = np.array([curve.variance for curve in curves])
    expected = al.expected(model, name, curves[0].tau, rate=1.0, size=2048)
    freedom = edf(STATISTICS[name], model, curves[0].m, 2048, 1.0)
    assert np.all(np.abs(V.mean(axis=0) - expected) < 5 * expected * np.sqrt(2 / freedom / len(V)))
    assert np.all(np.abs(V.var(axis=0) / (2 * expected**2 / freedom) - 1) < 5 * math.sqrt(2 / 59) * 1.5)


@rows("name", ["fdev", "wdev"])
def test_a_new_statistic_has_its_expectation_and_its_limits(name):
    as_expected(al.Q(3.0, "arcsec") + WALK, name)
    for noise in (WALK, "auto"):
        curve = al.deviation(simulated(WALK), name, noise=noise)
        low, high = curve.interval(0.95)
        assert np.all((low < curve.deviation) & (curve.deviation < high))
        assert np.all(np.diff(curve.edf) < 0)


@rows("name", ["fdev", "wdev"])
def test_a_new_statistic_in_sliding_windows_and_in_parts(name, tmp_path):
    record = simulated(al.N(0.1, "deg/sqrt(h)"), 600)
    surface = al.dynamic(record, name, window=200.0, step=200.0)
    alone = al.deviation(record.with_values(record.values[200:400], ""), name, m=surface.m.tolist())
    np.testing.assert_allclose(surface.variance[1], alone.variance, rtol=1e-10)
    np.save(tmp_path / "z.npy", record.values)
    line = [str(tmp_path / "z.npy"), "--rate", "1", "--unit", "rad/s", "--statistic", name, "--memory", "1kB"]
    ends(run("deviation", *line), 2, f"no {name!r}: choose one of oadev, mdev")


@rows("name, method", paired(["fdev", "wdev"], ["gls", "nnls"]))
def test_a_new_statistic_is_read_by_fits(name, method):
    fit = al.identify(simulated(WALK), method, terms="NK", statistic=name)
    assert fit.model["N"].value == pytest.approx(WALK["N"].value, rel=0.1)
    assert (fit["N"].standard_error is not None) == (method == "gls")
    if name == "fdev":
        assert np.linalg.eigvalsh(covariance(FDEV, WALK, np.array([1, 2, 4]), 2000, 1.0)).min() > 0
        with pytest.raises(al.UsageError):
            al.identify(simulated(WALK), "ls", statistic="fdev")


def test_a_new_term_is_made_written_and_read():
    model = al.Model(MODEL)
    assert str(model) == str(al.Z(3.0, "arcsec") + al.N(0.01, "deg/sqrt(h)"))
    assert model["Z"] == term("Z", 3.0, "arcsec")
    assert al.Model.from_dict(model.to_dict()) == model
    refused(TypeError, "unexpected keyword", lambda: al.Z(3.0, "arcsec", time_constant=1.0))
    with pytest.raises(AttributeError):
        al.Y  # noqa: B018


@rows("name", ["oadev", "totdev", "fdev"])
def test_a_new_term_has_expectation_and_limits_in_every_statistic(name):
    as_expected(al.Model(MODEL), name)


def test_the_law_at_each_tau_may_be_that_of_a_new_term():
    assert symbol_of(1) == "F"
    with TERMS.trying("F", TERMS["GM"]):
        assert symbol_of(1) == "Z"
        assert al.deviation(simulated(al.Z(3.0, "arcsec")), "oadev").interval(0.95)[0].min() > 0


@rows("method, statistic", [("whittle", None), ("gls", "oadev")])
def test_a_new_term_is_identified(method, statistic):
    model = al.Z(3.0, "arcsec") + al.K(50.0, "deg/h/sqrt(h)")
    fit = al.identify(simulated(model, 2**14), method, terms="Z,K", statistic=statistic)
    assert fit["Z"].value == pytest.approx(model["Z"].value, rel=0.05)
    assert al.bound(model, 2**14, 1.0)["Z"] < 0.02


def test_a_filter_refuses_a_term_without_states_and_takes_one_that_has_some():
    words = r"Z \(wander of the angle\) has no states in a filter, Q, N, B, K, R, GM, GML, GMA, GM2"
    refused(al.UsageError, words, lambda: al.state_space(al.Model(MODEL), 1.0))
    with TERMS.trying("W", replace(TERMS["K"], symbol="W", title="another walk")):
        plain, other, both = (al.state_space(al.Model(f"N 1 rad/sqrt(s), {more}"), 2.0) for more in (
            "K 0.1 rad/s^1.5", "W 0.1 rad/s^1.5", "K 0.3 rad/s^1.5, W 0.4 rad/s^1.5"))  # fmt: skip
    np.testing.assert_array_equal(plain.Qd, other.Qd)
    assert both.Qd[0, 0] == pytest.approx(0.25 * 0.5)


@pytest.mark.slow("takes more than half a second")
def test_new_rows_have_their_pages(tmp_path, monkeypatch):
    pytest.importorskip("sphinx", reason="the documentation's tools are not installed here")
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from generate.statistics import statistic_index, statistic_page
    from generate.terms import term_index, term_page

    assert "wander of the angle" in "\n".join(term_page("Z", tmp_path))
    assert "wdev" in "\n".join(statistic_page("wdev", tmp_path))
    assert "[Z](Z.md)" in "\n".join(term_index())
    assert "[fdev](fdev.md)" in "\n".join(statistic_index())


def relaxing():
    return al.N(0.1, "deg/sqrt(h)") + al.RR(2e-6, "rad/s^2.5", time_constant=20.0)


def test_units_follow_from_the_power():
    for signal in SIGNALS:
        expected = unit_of(signal.unit) * unit_of("s") ** -1.5
        assert unit_of(signal.si[-1.5]) == expected, signal.name
        assert unit_of(signal.sheet[-1.5]).dimension == expected.dimension, signal.name


def test_a_term_of_a_new_power_is_written_and_read():
    again = al.Model(str(relaxing()))
    assert str(again) == str(relaxing())
    assert al.Model(written(relaxing())) == relaxing() == al.Model.from_dict(relaxing().to_dict())
    assert relaxing()["RR"].unit == "rad/s^2.5"
    refused(al.UnitError, r"usual units: deg/h\^2.5, ug/h\^1.5", lambda: al.RR(1.0, "rad/s", time_constant=1.0))


def test_a_term_of_a_new_power_is_expected_simulated_and_identified():
    as_expected(relaxing(), "oadev")
    fit = al.identify(simulated(relaxing()), terms="N,RR")
    assert (fit["RR"].status, fit["RR"].shape[0]) == ("identified", pytest.approx(20.0, rel=0.3))
    assert fit["RR"].value == pytest.approx(2e-6, rel=0.3)
    with pytest.raises(al.UsageError, match="RR"):  # a fit of a curve knows no terms with a shape
        al.identify(simulated(relaxing()), "gls", terms="N,RR", statistic="oadev")


@pytest.mark.slow("takes more than half a second")
def test_everything_that_takes_a_model_takes_a_term_of_a_new_power(tmp_path):
    assert al.bound(relaxing(), 2**13, 1.0)["RR"] < 0.2
    space = al.state_space(relaxing(), 1.0)
    assert space.P0[0, 0] == pytest.approx((2e-6 * 20**1.5) ** 2)
    study = al.analyze(simulated(relaxing()), al.Recipe(terms="N,RR", to=("rad/s^2.5",)))
    assert "driven relaxation" in page(study)
    assert "rad/s^2.5" in study.channels[0].fit["RR"].to_dict()["shown"]["unit"]
    al.plot(study, path=tmp_path / "z.svg")
    assert al.from_dict(study.to_dict()).channels[0].fit["RR"].shape == study.channels[0].fit["RR"].shape


def test_a_term_and_a_fit_stand_for_a_model():
    K = al.K(5.0, "deg/h/sqrt(h)")
    record = simulated(K, 1024)
    fit = al.identify(record, terms="NK")
    for noise, same in ((K, al.Model((K,))), (fit, fit.model)):
        curve, rel = al.deviation(record, noise=noise), 0.05 if noise is fit else 1e-12
        assert curve.noise == same
        # of a fit, of all the models that it leaves open
        np.testing.assert_allclose(curve.edf, al.deviation(record, noise=same).edf, rtol=rel)
    np.testing.assert_array_equal(al.expected(fit, "oadev", [1.0]), al.expected(fit.model, "oadev", [1.0]))
    assert al.simulate(fit, 64, 1.0, rng=np.random.default_rng(1)).size == 64


@rows("noise", ["banana", [1]])
def test_what_is_no_model_is_refused_by_name(noise):
    record = simulated(al.N(1.0, "deg/sqrt(h)"), 256)
    came = repr(noise) if isinstance(noise, str) else type(noise).__name__
    for call in (
        lambda: al.deviation(record, noise=noise), lambda: al.dynamic(record, noise=noise),
        lambda: al.expected(noise, "oadev", [1.0]), lambda: al.simulate(noise, 10, 1.0, rng=np.random.default_rng(1)),
        lambda: al.state_space(noise, 1.0), lambda: al.bound(noise, 100, 1.0), lambda: al.plan(noise, 1.0),
        lambda: al.selfcheck(noise, 100, 1.0, rng=np.random.default_rng(1)),
        lambda: al.constant_rate.rank(noise, size=100, rate=1.0),
    ):  # fmt: skip
        refused(al.UsageError, f"a Model, a Term .* not .*{came}", call)
