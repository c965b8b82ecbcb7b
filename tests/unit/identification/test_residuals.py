"""Residuals: white under the truth, alarmed by what is wrong, and in the right words."""

import json

import numpy as np
import pytest
from tests.rows import paired, refused, rows
from tests.unit.identification import records
from tests.unit.identification.records import rates_of

import allanite as al
from allanite.identification.checks.residuals import LAGS, _sums
from allanite.reporting import page, plot, table

GM = al.GM(5, "deg/h", time_constant=2.0) + al.Sine(9, "deg/h", frequency=7.3, phase=0.4)
SENSORS = {
    "MEMS": al.sensor("mems"),
    "FOG": al.Model("Q 0.4 arcsec, N 0.05 deg/sqrt(h), B 1 deg/h, K 5.4 deg/h/sqrt(h), R 0.02 deg/h/s"),
    "GM": al.N(3, "deg/h*sqrt(s)") + GM,
    "RLG": al.sensor("rlg"),
}


def record_of(name, seed):
    return records.record_of(rates_of(SENSORS[name], 2**15, seed))


def recording_of(rate=100.0, **channels):
    return al.Recording([al.Record(y, rate, "deg/h", name=name) for name, y in channels.items()])


def noise_of(y, rate=100.0):
    return al.analyze(recording_of(rate, z=y)).channels[0].noise


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


@pytest.mark.slow("takes more than half a second")
@rows("name", ["MEMS", "FOG", "RLG"])
def test_clean_records_are_explained(name):
    """Anything is said against two in a hundred: 2 of 3 are with probability 0.001."""
    each = [record_of(name, seed) for seed in range(1, 4)]
    assert sum(not al.residuals(record, al.identify(record)).explained for record in each) <= 1


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


def test_residuals_are_plain_data_and_a_figure(tmp_path):
    record = record_of("MEMS", 1)
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
    refused(al.UsageError, "needs a model with noise", lambda: al.whitened(record, al.R(1.0, "deg/h/s")))
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
    y = record_of("RLG", 1).values
    y[::60] = np.nan
    record = records.record_of(y)
    left = al.residuals(record, al.identify(record))
    assert left.checks == ()
    assert left.verdict
    refused(al.UsageError, "too few samples", lambda: plot(left))


def both(share):
    common = share * 300 * np.random.default_rng(1).standard_normal(2**15)
    x, y = (record_of("MEMS", seed).values * np.degrees(3600) + common for seed in (2, 3))
    return recording_of(x=x, y=y, dead=np.full(2**15, 2.0))


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
    warm = al.simulate(al.K(3.0, "deg/h/sqrt(s)"), 2**15, 100.0, rng=rng).values * np.degrees(3600)
    x, y = rng.standard_normal((2, 2**15)) * 30 + warm
    recording = recording_of(x=x, y=y)
    found = al.shared(recording, al.identify(recording))
    assert "in means over 5.12 s" in found.findings[0].what


def test_a_recording_without_a_fit_says_why_of_every_channel():
    flat = recording_of(1.0, a=np.full(500, 2.0), b=[1.0, 2.0, 4.0])
    refused(al.DataError, r"(?s)'a'.*b: ", lambda: al.identify(flat))


def test_pairs_are_told_in_one_finding_that_names_the_closest():
    rng = np.random.default_rng(9)
    common = rng.normal(size=2**13)
    x, y, z = (share * common + rng.normal(size=2**13) for share in (1.0, 2.0, 0.5))
    recording = recording_of(10.0, x=x, y=y, z=z)
    (found,) = al.shared(recording, al.identify(recording)).findings
    assert found.what.startswith(
        "the residuals of 3 pairs of channels are correlated sample by sample, most of all those of x and y (+0.6"
    )


@pytest.mark.slow("takes more than half a second")
def test_a_study_shows_what_channels_share():
    study = al.analyze(both(0.5))
    data, shown = study.to_dict(), page(study)
    assert (data["channels"][2]["residuals"], data["shared"]["names"]) == (None, ["x", "y"])
    assert "are correlated sample by sample" in " ".join(table(study).split())
    assert shown.count("Residuals: does the model explain the record?") == 2
    assert "Correlation of the channels" in shown


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
    each = [al.simulate(model, 4096, 1.0, rng=np.random.default_rng((11, seed))) for seed in range(100)]
    residuals = [al.residuals(record, al.identify(record)) for record in each]
    assert sum(left["correlation"].p < 0.05 for left in residuals) <= 8


def test_a_level_that_hardly_changes_is_not_told():
    noise = noise_of(np.random.default_rng(1).standard_normal(2**17) * np.repeat([1.0, 1.06], 2**16))
    assert not noise.residuals["halves"].passed
    assert (noise.residuals.findings, noise.validity) == ((), "explained")


def test_loud_stretches_are_named_one_by_one():
    y = np.random.default_rng(1).standard_normal(2**15) * np.repeat([1.4, 1, 1, 1, 1.4, 1, 1, 1], 2**12)
    (finding,) = noise_of(y, 32.0).residuals.findings
    assert "is highest from 0 s to 128 s, from 512 s to 640 s" in finding.what


def test_what_a_warning_says_no_note_repeats():
    y = np.random.default_rng(3).standard_normal(2**14)
    y[5000] = 40.0
    shown = " ".join(table(al.analyze(recording_of(z=y))).split())
    assert shown.count("1 outlier beyond") == 1
    assert "standard deviations, at 50 s, of 4" in shown
