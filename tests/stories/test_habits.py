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
    study = al.analyze(table, rate=RATE)
    imu = path.with_name("imu.csv")
    pd.DataFrame({"gx [deg/s]": x, "ax [g]": y / 1000}).to_csv(imu, index_label="n")
    return {
        "al": al, "np": np, "pd": pd, "x": x, "y": y, "df": table, "timed": timed, "series": pd.Series(x, name="gx"),
        "path": str(path), "model": model, "record": record, "fit": fit, "curve": al.deviation(record),
        "study": study, "timed_imu": al.read(imu, rate=RATE), "folder": path.parent, "channel": study["gx"],
    }  # fmt: skip


def is_n(value):
    """Whether it is the coefficient that was simulated."""
    return abs(value / TRUTH - 1) < 0.1


WORKS = (
    # records
    ("al.Record(x, fs=100, unit='deg/s')", lambda r: r.rate == RATE),
    ("al.Record(series, fs=100, unit='deg/s')", lambda r: r.unit == "deg/s"),
    ("len(record)", lambda n: n == 2000),
    ("np.asarray(record)", lambda a: a.shape == (2000,)),
    ("al.Record(x, dt=0.01, unit='deg/s').rate", lambda rate: rate == RATE),
    ("record[:1000]", lambda r: r.size == 1000 and r.name == "gx"),
    ("record[1000:].time[0], record.time[1000]", lambda times: times == (10, 10)),
    ("record.mean(), record.std()", lambda found: abs(found[0]) < found[1]),
    ("record.to('rad/s').values[0] / record.values[0]", lambda ratio: ratio == pytest.approx(np.pi / 180)),
    ("record.to_dataframe()", lambda t: list(t) == ["time [s]", "gx [deg/s]"] and len(t) == 2000),
    # tables
    ("al.read(df, fs=100)", lambda r: r.channels == ("gx", "gy")),
    ("al.read(timed)['gx']", lambda r: r.rate == pytest.approx(RATE)),
    ("al.read(path, fs=100)", lambda r: len(r) == 2),
    # curves
    ("al.deviation(x, rate=100)", lambda c: c.unit == "1" and c.statistic == "oadev"),
    ("al.deviation(x, 'mdev', fs=100, taus=[0.1, 1.0])", lambda c: c.tau.tolist() == [0.1, 1.0]),
    ("al.constant_rate.estimate(x, 'mean', fs=100, unit='deg/s')", lambda found: found.duration == 20),
    ("al.spectrum(x, fs=100)", lambda s: s.frequency.max() < RATE / 2),
    ("al.dynamic(x, fs=100, window=5)", lambda s: s.deviation.ndim == 2),
    ("al.deviation(record, taus=np.logspace(-1, 1, 5))", lambda c: c.tau.tolist() == [0.1, 0.32, 1, 3.16, 10]),
    ("al.deviation(record, taus=np.logspace(-1, 1, 5)).history", lambda lines: "rounded" in lines[-1]),
    ("[len(column) for column in curve]", lambda sizes: len(sizes) == 2 and sizes[0] == sizes[1]),
    ("curve.taus is curve.tau, curve['tau'] is curve.tau", lambda same: same == (True, True)),
    ("curve.dev == curve.adev", lambda same: same.all()),
    ("repr(al.minimum(curve))", lambda text: "deg/h" in text and "rad/s" in text),
    ("curve.to_dataframe()", lambda t: len(t) > 5 and "tau_s" in t),
    ("curve.plot()", lambda figure: len(figure.axes) > 0),
    # fits
    ("al.identify(series, fs=100, unit='deg/s')['N'].to(SHOWN)", is_n),
    ("al.identify(df['gx [deg/s]'], rate=100).N.to(SHOWN)", is_n),
    ("al.identify(df, rate=100)['gy'].N.to(SHOWN)", is_n),
    ("al.identify(record, terms=['N', 'K'])", lambda f: [e.symbol for e in f] == ["N", "K"]),
    ("fit.N.low, fit['N'].high", lambda limits: limits[0] < TRUTH * np.pi / 180 / 60 < limits[1]),
    ("fit.to_dataframe().set_index('term').loc['N', 'value']", is_n),
    ("float(fit['N']) == fit.N.value", bool),
    ("fit.coefficients['N'].to(SHOWN), fit.params['N'].to(SHOWN)", lambda found: all(map(is_n, found))),
    ("repr(fit['N'])", lambda text: "deg/sqrt(h) = " in text and "rad/sqrt(s)" in text),
    ("fit.summary()", lambda text: "angle random walk" in text),
    ("fit._repr_html_()", lambda html: "<table" in html and "<svg" in html),
    ("fit.plot(), fit.plot(folder / 'a.png')", lambda figures: all(len(figure.axes) > 0 for figure in figures)),
    ("record.plot()", lambda figure: len(figure.axes) == 1),
    # jobs
    ("al.analyze(df, rate=100)", lambda study: len(study.channels) == 2),
    ("al.analyze(path, fs=100, terms=['N', 'K'])['gx'].fit.N.to(SHOWN)", is_n),
    ("study.to_dataframe()", lambda t: "N" in set(t.iloc[:, 1])),
    ("study.to_dataframe(coefficients=False)", lambda t: len(t) > 20),
    ("study.curves['gx']", lambda c: len(c.tau) > 5),
    ("channel.N.to(SHOWN), channel['N'].to(SHOWN), study.gx.N.to(SHOWN)", lambda found: all(map(is_n, found))),
    ("study.fits['gy'].N.to(SHOWN)", is_n),
    ("study.report(folder / 'page.html')", lambda nothing: nothing is None),
    ("study.gx.fit.export(target='datasheet').text", lambda text: "gx" in text),
    ("al.export(timed_imu, 'kalibr', unexplained=True)['gyroscope_noise_density']", lambda v: v > 0),
    ("al.analyze(np.stack([x, y], axis=1), rate=100, unit='deg/s').channels", lambda found: len(found) == 2),
    ("al.drift(fit)['heading'].to('deg')", lambda sigma: sigma.shape == (5,)),
    ("al.drift(record, times=60)['position'].sigma", lambda sigma: sigma[0] > 0),
    ("al.compare(x, y, rate=100, unit='deg/s')", lambda found: not found.pairs[0].changed),
    # models and simulation
    ("al.Model('N 0.1 deg/sqrt(h), K 1 deg/h/sqrt(h)')['K'].value", lambda v: v > 0),
    ("al.simulate(model, size=500, fs=100)", lambda r: r.size == 500),
    ("al.simulate(model, rate=100, duration='1 min', seed=1)", lambda r: r.size == 6000),
    ("al.N('0.1 deg/sqrt(h)').to(SHOWN)", lambda v: v == pytest.approx(TRUTH)),
    ("al.convert(0.1, 'deg/sqrt(h)', 'deg/s/sqrt(Hz)')", lambda v: v == pytest.approx(TRUTH / 60)),
    ("al.W(1, 'deg/h', time_constant=5.0).shape", lambda shape: shape == (5,)),
    ("al.pool, al.faults.gaps, al.budget", lambda found: all(map(callable, found))),
    ("al.selfcheck(model, size=500, rate=100, records=2, rng=1)", lambda check: check.size == 500),
)  # fmt: skip
"""What is typed, and what is expected of it."""

REFUSED = (
    ("al.identify(x, rate=100)", "type al.identify(x, rate=100, unit='deg/s')"),
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
    ("al.avar(x)", "al.deviation(x, 'oadev', rate=100)"),
    ("al.psd(x)", "al.spectrum(record)"),
    ("al.read_csv(path)", "al.read(file)"),
    ("al.fit(record)", "al.identify(record)"),
    ("al.save(record, path)", "al.write(recording, path)"),
    ("al.diff(x, y)", "al.compare(before, after)"),
    ("al.identfy(record)", "did you mean identify?"),
    ("al.spectrum(record, nperseg=1024)", "al.spectrum(record, al.Welch(segment=seconds))"),
    ("al.Record(x, time=x, unit='deg/s')", "al.read(table, time=column)"),
    ("al.deviation(x, 100)", "al.deviation(x, rate=100)"),
    ("al.deviation(record, taus=[0.001])", "the nearest is 0.01 s"),
    ("al.N(0.1)", "N needs a number and its unit"),
    ("curve.plot(ax=None)", "ax.loglog(*curve)"),
    ("curve['time']", "known columns: tau"),
    ("fit.aic", "fit.alternatives"),
    ("record.psd()", "al.spectrum(record)"),
    ("record.shape", "record.values"),
    ("record[::10]", "al.prepare.decimate(record, 10)"),
    ("study.save('a.html')", "al.report(study, path)"),
    ("study.to_json()", "json.dumps(study.to_dict())"),
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
