"""Residuals: white under the truth, alarmed by what is wrong, and in the right words."""

import json

import numpy as np
import pytest
from tests.rows import paired, refused, rows

import allanite as al
from allanite.identification.checks.residuals import LAGS, _sums
from allanite.reporting import page, plot, table

SENSORS = {
    "MEMS": al.N(0.005, "deg/sqrt(s)") + al.B(0.002, "deg/s") + al.K(3e-4, "deg/s/sqrt(s)"),
    "FOG": al.Q(0.4, "arcsec")
    + al.N(3, "deg/h*sqrt(s)")
    + al.B(1, "deg/h")
    + al.K(0.09, "deg/h/sqrt(s)")
    + al.R(0.02, "deg/h/s"),
    "GM": al.N(3, "deg/h*sqrt(s)")
    + al.GM(5, "deg/h", time_constant=2.0)
    + al.Sine(9, "deg/h", frequency=7.3, phase=0.4),
    "RLG": al.Q(0.5, "arcsec") + al.N(0.18, "arcsec/sqrt(s)") + al.B(0.05, "deg/h"),
}


def record_of(name, seed, n=2**15):
    return al.simulate(SENSORS[name], n, 100.0, rng=np.random.default_rng(seed))


@rows("name, lost", paired(list(SENSORS), [0, 300]))
def test_the_true_model_leaves_white_noise(name, lost):
    """Variance and twenty correlations within 5 standard errors: one failure in 10^5."""
    record = record_of(name, 1)
    values = record.values.copy()
    values[9000 : 9000 + lost] = np.nan
    u = al.whitened(al.Record(values, 100.0, "rad/s"), SENSORS[name]).astype(float)
    assert np.isnan(u).sum() == lost
    for part in (u[500:8500], u[10_000:-500]):
        n = part.size
        assert part.var() == pytest.approx(1, abs=5 * (2 / n) ** 0.5)
        r = np.array([part[h:] @ part[:-h] / n for h in range(1, 21)])
        assert np.abs(r).max() < 5 / n**0.5


@rows("kind", ["increment", "count", "angle"])
def test_every_kind_of_record_leaves_the_same(kind):
    rate = record_of("FOG", 2)
    step = 1e-12
    counts = np.rint(rate.values / 100 / step).astype(np.int64)
    forms = {
        "increment": al.Record(counts * step, 100.0, "rad", kind="increment"),
        "count": al.Record(counts, 100.0, "rad", kind="count", scale=step),
        "angle": al.Record(np.concatenate(([0], np.cumsum(counts))) * step, 100.0, "rad", kind="angle"),
    }
    expected = al.whitened(rate, SENSORS["FOG"])
    np.testing.assert_allclose(al.whitened(forms[kind], SENSORS["FOG"]), expected, atol=2e-3)


@pytest.mark.slow("takes more than half a second")
@rows("name", ["MEMS", "FOG", "RLG"])
def test_clean_records_are_explained(name):
    """Anything is said against two in a hundred: 2 of 3 are with probability 0.001."""
    fits = [(record, al.identify(record)) for record in (record_of(name, seed) for seed in range(1, 4))]
    assert sum(not al.residuals(*pair).explained for pair in fits) <= 1


def test_a_dithered_quantizer_is_explained():
    """The same with a dither of three steps, which was taken off again."""
    rng = np.random.default_rng(1)
    y = al.simulate(al.N(0.18, "arcsec/sqrt(s)"), 2**15, 100.0, rng=rng).values
    angle, dither = np.cumsum(y) / 100 / np.radians(1.73 / 3600), 3 * rng.uniform(-1, 1, 2**15)
    steps = np.diff(np.floor(angle + dither) - dither) * 1.73
    record = al.Record(steps, 100.0, "arcsec", kind="increment")
    fit = al.identify(record)
    assert fit["Q"].to("arcsec") == pytest.approx(1.73 / 12**0.5, rel=0.03)
    assert al.residuals(record, fit).explained


@pytest.mark.slow("takes more than half a second")
def test_residuals_are_plain_data_and_a_figure(tmp_path):
    record = al.Record(record_of("FOG", 1).values, 100.0, "rad/s", name="gx")
    left = al.residuals(record, al.identify(record))
    headings, rows = left.rows()
    assert [row[0] for row in rows] == ["correlation", "kurtosis", "halves", "eighths"]
    assert all(len(row) == len(headings) for row in rows)
    data = json.loads(json.dumps(left.to_dict()))
    assert data["type"] == "Residuals"
    assert {check["name"]: check["p"] for check in data["checks"]} == {c.name: c.p for c in left.checks}
    figure = plot(left, path=tmp_path / "left.svg")
    assert (tmp_path / "left.svg").stat().st_size > 10_000
    assert (len(figure.axes), left["kurtosis"].value) == (5, pytest.approx(0, abs=0.15))


def test_what_cannot_be_asked_is_refused():
    record = record_of("MEMS", 1)
    accelerometer = al.Record(record.values, 100.0, "m/s^2")
    fit = al.identify(record)
    refused(al.UsageError, "gyro", lambda: al.whitened(accelerometer, fit.model))
    refused(al.UsageError, "needs a model with noise", lambda: al.whitened(record, al.Model((al.R(1.0, "deg/h/s"),))))
    refused(al.UsageError, "'mark'", lambda: al.residuals(record, fit, outliers="fill"))
    refused(al.UsageError, "two channels", lambda: al.shared(al.Recording((record,)), {"": fit}))


def test_sums_are_those_of_the_products():
    u = np.random.default_rng(1).standard_normal(70_000).astype(np.float32)
    for first, last in ((100, 60_000), (40_000, u.size)):
        now, later = u[first:last].astype(float), np.concatenate((u[first:], np.zeros(LAGS))).astype(float)
        products = [float((now * later[h : h + now.size]).sum()) for h in range(LAGS + 1)]
        assert _sums(u, first, last) == pytest.approx([products[0], (now**4).sum(), *products[1:]], rel=1e-9, abs=1e-6)


def test_too_little_between_gaps_is_not_asked():
    """So many gaps in so much quantization that a joint is felt everywhere."""
    y = record_of("RLG", 1).values.copy()
    y[::60] = np.nan
    record = al.Record(y, 100.0, "rad/s", name="z")
    left = al.residuals(record, al.identify(record))
    assert left.checks == ()
    assert left.verdict
    refused(al.UsageError, "too few samples", lambda: plot(left))


def both(share):
    rng = np.random.default_rng(1)
    common = rng.standard_normal(2**15)
    channels = [
        al.Record(record_of("MEMS", seed).values * np.degrees(3600) + share * 300 * common, 100.0, "deg/h", name=name)
        for seed, name in ((2, "x"), (3, "y"))
    ]
    dead = al.Record(np.full(2**15, 2.0), 100.0, "deg/h", name="dead")
    return al.Recording((*channels, dead))


@rows("share", [0.0, 0.5])
def test_what_channels_share_is_named(share):
    recording = both(share)
    fits = al.identify(recording)
    assert list(fits) == ["x", "y"]
    found = al.shared(recording, fits)
    r = found.fast[0, 1]
    assert (abs(r) < 5 / 2**7.5) == (share == 0)
    assert [finding.name for finding in found.findings] == (["shared"] if share else [])
    assert found.rows()[1] == [["x", "y", r, found.slow[0, 1]]]
    assert json.loads(json.dumps(found.to_dict()))["names"] == ["x", "y"]


def test_slow_things_in_common_are_named():
    rng = np.random.default_rng(1)
    warm = al.simulate(al.Model((al.K(3.0, "deg/h/sqrt(s)"),)), 2**15, 100.0, rng=rng).values * np.degrees(3600)
    records = [al.Record(rng.standard_normal(2**15) * 30 + warm, 100.0, "deg/h", name=name) for name in "xy"]
    recording = al.Recording(tuple(records))
    found = al.shared(recording, al.identify(recording))
    assert "in means over 5.12 s" in found.findings[0].what


def test_a_recording_without_a_fit_says_why_of_every_channel():
    flat = al.Recording(
        (al.Record(np.full(500, 2.0), 1.0, "deg/h", name="a"), al.Record([1.0, 2.0, 4.0], 1.0, "deg/h", name="b"))
    )
    refused(al.DataError, r"(?s)'a'.*b: ", lambda: al.identify(flat))


def test_pairs_are_told_in_one_finding_that_names_the_closest():
    rng = np.random.default_rng(9)
    common = rng.normal(size=2**13)
    noise = {name: al.Record(share * common + rng.normal(size=2**13), 10.0, "deg/h", name=name)
             for name, share in (("x", 1.0), ("y", 2.0), ("z", 0.5))}  # fmt: skip
    recording = al.Recording(tuple(noise.values()))
    (found,) = al.shared(recording, al.identify(recording)).findings
    assert found.what.startswith(
        "the residuals of 3 pairs of channels are correlated sample by sample, most of all those of x and y (+0.6"
    )


@pytest.mark.slow("takes more than half a second")
def test_the_study_says_it_in_words_and_pictures():
    recording = both(0.5)
    y = recording["y"].values.copy()
    y[2**14 :] *= 3
    spoilt = al.Recording((recording["x"], recording["y"].with_values(y, "spoilt"), recording["dead"]))
    study = al.analyze(spoilt)
    x, z, dead = study.channels
    assert (x.explained, z.explained, dead.explained) == (True, False, False)
    shown = " ".join(table(study).split())
    assert "the noise level changes" in shown
    assert "are correlated sample by sample" in shown
    assert shown.count("the noise level changes") == 2
    assert "on the same body, y: the noise level changes" in shown
    html = page(study)
    assert html.count("Residuals: does the model explain the record?") == 2
    assert "Correlation of the channels" in html
    data = study.to_dict()
    assert data["channels"][2]["residuals"] is None
    assert (data["channels"][1]["residuals"]["findings"][0]["name"], data["shared"]["names"]) == ("level", ["x", "y"])


def test_a_band_has_residuals_and_says_where_it_holds():
    study = al.analyze(record_of("MEMS", 1), al.Recipe(band=(0.1, 50.0)))
    channel = study.channels[0]
    assert [check.name for check in channel.residuals.checks] == ["correlation", "kurtosis", "halves", "eighths"]
    assert channel.noise.statement.points == ("the model holds from 0.1 to 50 Hz, that is, from 0.01 s to 2.5 s",)
    assert "--band" not in channel.verdict


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
def test_a_weak_random_walk_that_was_not_selected_leaves_no_correlation():
    """100 records of the seeds 0 to 99: at 5 % about 5 fail; of the selected model's residuals 11 did."""
    model = al.N(1, "deg/sqrt(h)") + al.K(15, "deg/h/sqrt(h)")
    found = []
    for seed in range(100):
        record = al.simulate(model, 4096, 1.0, rng=np.random.default_rng((11, seed)))
        found.append(al.residuals(record, al.identify(record)).checks[0])
    assert {check.name for check in found} == {"correlation"}
    assert sum(check.p < 0.05 for check in found) <= 8


def test_a_level_that_hardly_changes_is_not_told():
    y = np.random.default_rng(1).standard_normal(2**17)
    y[2**16 :] *= 1.06
    noise = al.analyze(al.Record(y, 100.0, "deg/h", name="z")).channels[0].noise
    assert not noise.residuals["halves"].passed
    assert (noise.residuals.findings, noise.validity) == ((), "explained")


def test_loud_stretches_are_named_one_by_one():
    y = np.random.default_rng(1).standard_normal(2**15)
    for eighth in (0, 4):
        y[eighth * 2**12 : (eighth + 1) * 2**12] *= 1.4
    (finding,) = al.analyze(al.Record(y, 32.0, "deg/h", name="z")).channels[0].noise.residuals.findings
    assert "is highest from 0 s to 128 s, from 512 s to 640 s" in finding.what


def test_what_a_warning_says_no_note_repeats():
    y = np.random.default_rng(3).standard_normal(2**14)
    y[5000] = 40.0
    shown = " ".join(table(al.analyze(al.Record(y, 100.0, "deg/h", name="z"))).split())
    assert shown.count("1 outlier beyond") == 1
    assert "standard deviations, at 50 s, of 4" in shown
