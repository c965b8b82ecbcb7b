"""What people who come from pandas, allantools, scipy, statsmodels or scikit-learn type first."""

import pickle

import numpy as np
import pandas as pd
import pytest
from tests.rows import rows

import allanite as al

RATE = 100.0
SHOWN = "deg/sqrt(h)"
TRUTH = 0.1


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """What stands on the desk of someone who tries it: samples, a column, a table, a file."""
    model = al.Model("N 0.1 deg/sqrt(h)")
    x, y = (al.simulate(model, 2000, RATE, rng=seed, unit="deg/s").values for seed in (1, 2))
    table = pd.DataFrame({"gx [deg/s]": x, "gy [deg/s]": y})
    path = tmp_path_factory.mktemp("desk") / "gyro.csv"
    table.to_csv(path, index=False)
    record = al.Record(x, rate=RATE, unit="deg/s", name="gx")
    timed = table.set_axis(pd.to_timedelta(np.arange(len(table)) / RATE, unit="s"))
    fit = al.identify(record)
    return {
        "al": al, "np": np, "pd": pd, "x": x, "y": y, "df": table, "timed": timed, "series": pd.Series(x, name="gx"),
        "path": str(path), "model": model, "record": record, "fit": fit, "curve": al.deviation(record),
    }  # fmt: skip


def is_n(value):
    """Whether it is the coefficient that was simulated."""
    return abs(value / TRUTH - 1) < 0.1


WORKS = (
    # records
    ("al.Record(x, rate=100, unit='deg/s')", lambda r: r.size == 2000),
    ("al.Record(x, fs=100, unit='deg/s')", lambda r: r.rate == RATE),
    ("al.Record(series, fs=100, unit='deg/s')", lambda r: r.unit == "deg/s"),
    ("len(record)", lambda n: n == 2000),
    ("np.asarray(record)", lambda a: a.shape == (2000,)),
    ("np.std(record)", lambda s: s > 0),
    # tables
    ("al.read(df, fs=100)", lambda r: r.channels == ("gx", "gy")),
    ("al.read(timed)['gx']", lambda r: r.rate == pytest.approx(RATE)),
    ("al.read(path, fs=100)", lambda r: len(r) == 2),
    # curves
    ("al.deviation(x, rate=100)", lambda c: c.unit == "1" and c.statistic == "oadev"),
    ("al.deviation(x, 'mdev', fs=100, taus=[0.1, 1.0])", lambda c: c.tau.tolist() == [0.1, 1.0]),
    ("al.deviation(df['gx [deg/s]'], rate=100)", lambda c: c.unit == "rad/s"),
    ("al.deviation(timed['gx [deg/s]'])", lambda c: c.tau[0] == pytest.approx(1 / RATE)),
    ("al.constant_rate.estimate(x, 'mean', fs=100, unit='deg/s')", lambda found: found.duration == 20),
    ("al.spectrum(x, fs=100)", lambda s: s.frequency.max() < RATE / 2),
    ("al.dynamic(x, fs=100, window=5)", lambda s: s.deviation.ndim == 2),
    ("curve.to_dataframe()", lambda t: len(t) > 5 and "tau_s" in t),
    ("curve.plot()", lambda figure: len(figure.axes) > 0),
    ("al.plot(curve, fit)", lambda figure: len(figure.axes) > 0),
    # fits
    ("al.identify(x, rate=100, unit='deg/s').N.to(SHOWN)", is_n),
    ("al.identify(series, fs=100, unit='deg/s')['N'].to(SHOWN)", is_n),
    ("al.identify(df['gx [deg/s]'], rate=100).N.to(SHOWN)", is_n),
    ("al.identify(df, rate=100)['gy'].N.to(SHOWN)", is_n),
    ("al.identify(record, terms=['N', 'K'])", lambda f: [e.symbol for e in f] == ["N", "K"]),
    ("fit.N.value", lambda v: v == pytest.approx(TRUTH * np.pi / 180 / 60, rel=0.1)),
    ("fit.N.low, fit['N'].high", lambda limits: limits[0] < TRUTH * np.pi / 180 / 60 < limits[1]),
    ("fit.to_dataframe().set_index('term').loc['N', 'value']", is_n),
    ("fit.summary()", lambda text: "angle random walk" in text),
    ("print(fit.summary())", lambda nothing: nothing is None),
    ("fit._repr_html_()", lambda html: "<table" in html and "<svg" in html),
    ("fit.plot()", lambda figure: len(figure.axes) > 0),
    ("record.plot()", lambda figure: len(figure.axes) == 1),
    ("record._repr_html_()", lambda html: "gx" in html),
    # jobs
    ("al.analyze(df, rate=100)", lambda study: len(study.channels) == 2),
    ("al.analyze(path, fs=100, terms=['N', 'K'])['gx'].fit.N.to(SHOWN)", is_n),
    ("al.analyze(x, rate=100, unit='deg/s').to_dataframe()", lambda t: len(t) > 5),
    ("al.analyze(np.stack([x, y], axis=1), rate=100, unit='deg/s').channels", lambda found: len(found) == 2),
    ("al.drift(fit)['heading'].to('deg')", lambda sigma: sigma.shape == (5,)),
    ("al.drift(record, times=60)['position'].sigma", lambda sigma: sigma[0] > 0),
    ("al.compare(x, y, rate=100, unit='deg/s')", lambda found: not found.pairs[0].changed),
    # models and simulation
    ("al.Model('N 0.1 deg/sqrt(h), K 1 deg/h/sqrt(h)')['K'].value", lambda v: v > 0),
    ("al.simulate(model, rate=100, duration=60, rng=1)", lambda r: r.size == 6000),
    ("al.simulate(model, size=500, fs=100, rng=1)", lambda r: r.size == 500),
    ("al.selfcheck(model, size=500, rate=100, records=2, rng=1)", lambda check: check.size == 500),
)  # fmt: skip
"""What is typed, and what is expected of it."""

REFUSED = (
    ("al.identify(x, rate=100)", "type al.identify(x, rate=100, unit='deg/s')"),
    ("al.identify(x)", "type al.identify(x, rate=100, unit='deg/s')"),
    ("al.analyze(x, rate=100, unit='deg/s', channels=['gx'])", "channels describes a file or a table, not an array"),
    ("al.deviation(0.1, rate=100)", "deviation takes a record or samples, not 0.1 (float)"),
    ("al.deviation(x)", "type al.deviation(x, rate=100"),
    ("al.analyze(x, fs=100)", "type al.analyze(x, rate=100, unit='deg/s')"),
    ("al.deviation(x, rate=100, fs=100)", "rate and fs are the same: give one of them"),
    ("al.deviation(record, rate=100)", "has its own rate"),
    ("al.deviation(df, rate=100)", "choose one"),
    ("al.deviation(path)", "al.deviation(al.read("),
    ("al.identify(fit)", "identify takes a record, samples or a curve, not a Fit"),
    ("al.analyze(df, rat=100)", "unknown key 'rat'"),
    ("fit.N.interval(95)", "did you mean 0.95?"),
    ("al.analyze(df, rate=100, level=95)", "did you mean 0.95?"),
    ("al.simulate(model, rate=100, rng=1)", "size, a number of samples, or duration"),
    ("al.simulate(model, size=100, rng=1)", "give rate"),
    ("al.simulate('N 0.1 deg/sqrt(h)', 100, 1, rng=1)", "Model(text)"),
    ("al.oadev(x, rate=100)", "al.deviation(x, 'oadev', rate=100)"),
)
"""What cannot be done as it is typed, and the call that the refusal names."""


@pytest.mark.slow("seconds of analyses")
@rows("code, holds", WORKS, ids=[code for code, _ in WORKS])
def test_it_works_at_first_try(desk, code, holds):
    assert holds(eval(code, {**desk, "SHOWN": SHOWN}))  # noqa: S307 - from the table


@rows("code, remedy", REFUSED, ids=[code for code, _ in REFUSED])
def test_it_is_refused_in_one_sentence_that_names_the_call(desk, code, remedy):
    with pytest.raises((al.UsageError, AttributeError)) as refusal:
        eval(code, desk)  # noqa: S307 - from the table
    said = str(refusal.value)
    assert remedy in said
    assert "\n" not in said
    assert len(said) < 300


def test_what_a_fit_lacks_is_no_attribute(desk):
    assert not hasattr(desk["fit"], "GM")
    assert pickle.loads(pickle.dumps(desk["fit"])).N.value == desk["fit"].N.value
