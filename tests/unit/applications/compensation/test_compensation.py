"""Compensation by regressors: the algebra against dense matrices, what is chosen, what is refused, what is kept."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from tests.reference.regression import dense
from tests.rows import refused, rows

import allanite as al
from allanite.applications.compensation import FitSettings, Regressor, aligned, compensate, gain_on, load
from allanite.applications.compensation.mixture import mixture, restricted
from allanite.applications.compensation.regressor import local_slope
from allanite.reporting import table

NOISE = al.N(0.1, "deg/sqrt(h)") + al.K(2.0, "deg/h/sqrt(h)")
HOUR = np.arange(3600.0)


def gyro(seed, effect=0.0, *, model=NOISE, n=3600, name="z"):
    noise = al.simulate(model, n, 1.0, rng=np.random.default_rng(seed), name=name)
    return al.Record(noise.values + effect, 1.0, "rad/s", name=name)


def channel(values, unit="degC", name="temp", **more):
    return al.Record(values, 1.0, unit, name=name, **more)


def cycles(n=3600, period=1300.0):
    return 20 + 5 * np.sin(2 * np.pi * np.arange(n) / period + 1)


TEMP = channel(cycles())


@rows("seed", [0, 1, 2])
def test_powers_enter_together_where_the_lower_one_alone_does_harm(seed):
    """Blocks see other temperatures: a parabola that stands in for a third power leads astray there."""
    x = np.sin(2 * np.pi * HOUR / 2400)
    y = gyro(seed, 1e-3 * (x + 0.4 * x**2 + 0.5 * x**3))
    found = compensate(y, channel(42 + 22 * x), ["temp"], degree=4)
    assert [regressor.label for regressor in found.regressors] == ["temp", "temp^2", "temp^3", "time"]
    assert found.held.explained > 0.99


@rows("stretches", [[(0, 60)], [(0, 25), (30, 60)]])
@rows("theta, off", [([0, 1.0, 0, 0.01], 1e-8), ([0.3, 1.0, 0, 0.01], 0.02), ([0.3, 1.0, 0.5, 0.01], 0.15)])
def test_coefficients_and_likelihood_are_those_of_full_matrices(stretches, theta, off):
    """Exact for white noise and a random walk; flicker is nearly diagonal in the cosine transform."""

    def exact(theta):
        return dense(y, X, stretches, dict(zip("QNBK", np.sqrt(theta), strict=True)))

    rng, theta = np.random.default_rng(1), np.array(theta)
    y, X = np.cumsum(rng.standard_normal(60)), np.column_stack([np.cumsum(rng.standard_normal(60)), np.arange(60.0)])
    seen = restricted(y, X, stretches, rate=1.0, symbols="QNBK")
    eta, V, _ = seen.directions(theta)
    flat = np.flatnonzero(seen.flat)
    beta, covariance, likelihood = exact(theta)
    error = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose((eta[flat] - beta) / error, 0, atol=10 * off if off < 1e-6 else off)
    size = np.outer(error, error)
    np.testing.assert_allclose(V[np.ix_(flat, flat)] / size, covariance / size, atol=off)
    other = theta * np.array([2.0, 0.5, 2.0, 3.0])
    difference = 2 * (seen.value(other) - seen.value(theta))
    assert difference == pytest.approx(exact(other)[2] - likelihood, rel=1e-8, abs=3 * off)


def test_the_mixture_is_wider_than_one_noise_and_its_numbers_agree():
    seen = restricted(gyro(1).values, (TEMP.values - 20)[:, None], [(0, 3600)], rate=1.0, symbols="QNBK")
    best, mean, found = mixture(seen, "QNBK")
    assert found.weights.sum() == pytest.approx(1)
    assert found.errors[0] > np.sqrt(seen.directions(best)[1][-1, -1])
    assert np.all(mean >= 0)
    for level in (0.025, 0.5, 0.9):
        assert found.below(found.quantile(level, 0), 0) == pytest.approx(level, abs=1e-6)


def test_an_effect_is_found_taken_off_and_written_down():
    slope, along = 1e-5, al.Recording((TEMP,))
    record = gyro(3, slope * TEMP.values)
    found = compensate(record, al.Recording((record, TEMP)), ["temp"])
    effect = found["temp"]
    assert effect.low < slope < effect.high
    assert (found.significant, effect.significant, effect.chosen) == (True, True, False)
    assert effect.t == pytest.approx(slope / effect.standard_error, abs=4)
    after = found.apply(record, along)
    assert after.history == ("corrected: regression on temp",)
    # what is taken off is zero at the mean temperature: the bias stays
    assert after.values.mean() == pytest.approx(record.values.mean(), abs=1e-9)
    # the drift that was estimated beside it stays, too: the variances are those about a straight line
    rest, whole = (np.sum((r.values - np.polyval(np.polyfit(HOUR, r.values, 1), HOUR)) ** 2) for r in (after, record))
    assert found.inside.explained == pytest.approx(1 - rest / whole, rel=1e-6)
    alone = compensate(record, TEMP, ["temp"], trend=False)
    taken = alone.apply(record, along).values
    assert alone.inside.explained == pytest.approx(1 - taken.var() / record.values.var(), rel=1e-9)
    assert found.held.explained > 0.5


def test_an_effect_of_a_million_times_the_noise_loses_no_digits():
    small, large = (compensate(gyro(4, size * TEMP.values), TEMP, ["temp"]) for size in (0.0, 1.0))
    assert large["temp"].value - 1.0 == pytest.approx(small["temp"].value, rel=1e-4)
    assert large["temp"].standard_error == pytest.approx(small["temp"].standard_error, rel=1e-4)


RATES, WORTH = 1e-5 * TEMP.values, 1e-9
KINDS = [("rate", "rad/s", RATES, {}), ("increment", "rad", RATES, {}),
         ("angle", "rad", np.append(0.0, np.cumsum(RATES)), {}),
         ("count", "rad", np.rint(RATES / WORTH), {"scale": WORTH})]  # fmt: skip


@rows("kind, unit, values, more", KINDS)
def test_every_kind_of_record_is_corrected_alike(kind, unit, values, more):
    found, along = compensate(gyro(5, RATES), TEMP, ["temp"]), al.Recording((TEMP,))
    record = channel(values, unit, "z", kind=kind, **more)
    corrected = found.apply(record, along)
    np.testing.assert_allclose(corrected.rate_values, RATES - found.rate_error(record, along), atol=WORTH)
    assert corrected.kind == ("increment" if kind == "count" else kind)


def test_a_channel_that_is_read_with_an_angle_has_the_means_of_the_intervals():
    found = compensate(gyro(5, RATES), TEMP, ["temp"])
    angle = channel(np.cumsum(RATES), "rad", "z", kind="angle")
    ends, middle = (al.Recording((channel(v),)) for v in (TEMP.values, (TEMP.values[1:] + TEMP.values[:-1]) / 2))
    np.testing.assert_allclose(found.rate_error(angle, ends), found.rate_error(angle, middle), rtol=1e-12)


def test_what_was_saved_corrects_in_the_same_way_and_what_is_no_regression_is_refused(tmp_path):
    record, along = gyro(6, 1e-5 * TEMP.values + 1e-6 * (TEMP.values - 20) ** 2), al.Recording((TEMP,))
    found = compensate(record, TEMP, ["temp"], derivative_of=["temp"], degree=2, lags=(60.0,), trend=True)
    found.save(tmp_path / "regression.json")
    again = al.compensation.Regression.load(tmp_path / "regression.json")
    np.testing.assert_array_equal(again.error(record, along), found.error(record, along))
    assert (again.to_dict(), gain_on(again, record, along)) == (found.to_dict(), gain_on(found, record, along))
    refused(al.UsageError, "already exists", lambda: found.save(tmp_path / "regression.json"))
    path = tmp_path / "wrong.json"
    al.compensation.save((found, found), path)
    refused(al.DataError, "contains 2 regressions", lambda: al.compensation.Regression.load(path))
    for text, words in (
        ("[]", "contains no saved regression"), ("{", "cannot be read"),
        ('{"regressions": [{"type": "Regression"}]}', "not a saved regression"),
        ('{"regressions": [{"type": "Fit"}]}', "not a saved regression"),
    ):  # fmt: skip
        path.write_text(text)
        refused(al.DataError, words, lambda: load(path))
    data = compensate(gyro(7), TEMP, ["temp"]).to_dict()
    data["mixture"]["spreads"][0][0] = -1.0
    refused(al.DataError, "changed", lambda: al.compensation.Regression.from_dict(data))


def test_powers_enter_where_held_back_blocks_gain_and_lags_as_they_are_asked_for():
    temp = channel(cycles(period=400.0))
    centred = temp.values - temp.values.mean()
    bent = compensate(gyro(8, 1e-5 * centred + 2e-6 * centred**2), temp, ["temp"], degree=3)
    assert [e.label for e in bent][:2] == ["temp", "temp^2"]
    assert bent["temp^2"].chosen
    assert bent["temp^2"].low < 2e-6 < bent["temp^2"].high
    late = np.concatenate((np.zeros(60), centred[:-60]))
    lagged = compensate(gyro(9, 1e-5 * late), temp, ["temp"], lags=(60.0,))["temp, 60 s before"]
    assert lagged.low < 1e-5 < lagged.high
    assert (lagged.regressor.column_unit, lagged.chosen) == ("degC", False)


@pytest.mark.slow("takes more than half a second")
def test_nothing_is_added_to_a_straight_line_but_seldom():
    """Each of two columns enters with a probability of about a sixth; more than 7 of 20 has one of 1 in 1000."""
    temp = channel(cycles(period=400.0))
    found = [compensate(gyro(seed, 1e-5 * temp.values), temp, ["temp"], degree=2) for seed in range(1, 21)]
    assert sum(len(f.taken) > 1 for f in found) <= 7
    every = compensate(gyro(1), temp, ["temp"], degree=2, settings=FitSettings(every=True))
    assert [e.label for e in every] == ["temp", "temp^2", "time"]


@rows("seed, lost, note", [(10, np.arange(1000, 1010), "2 stretches"),
                           (11, np.random.default_rng(1).choice(3600, 12, replace=False), "stretches")])  # fmt: skip
def test_gaps_are_an_error_or_split_the_record(seed, lost, note):
    record = gyro(seed, 1e-5 * TEMP.values)
    record = replace(record, values=np.where(np.isin(np.arange(3600), lost), np.nan, record.values))
    refused(
        al.DataError, rf"{lost.size} samples of 'z' .* missing; .*split", lambda: compensate(record, TEMP, ["temp"])
    )
    found = compensate(record, TEMP, ["temp"], settings=FitSettings(split_gaps=True))
    assert found["temp"].low < 1e-5 < found["temp"].high
    assert note in found.notes[0]
    corrected = found.apply(record, al.Recording((TEMP,)))
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(corrected.values)), np.sort(lost))


RAMP = -2e-8 * HOUR
WARMING = channel(20 + 10 * (1 - np.exp(-HOUR / 1800)))


def test_a_temperature_beside_a_ramp_has_its_own_coefficient():
    """Raw variances hide it, and without the ramp its sign is wrong."""
    quiet = al.Model("N 0.01 deg/sqrt(h)")
    record = gyro(12, 3e-6 * WARMING.values + RAMP, model=quiet)
    found = compensate(record, WARMING, ["temp"])
    assert found["temp"].low < 3e-6 < found["temp"].high
    assert found["temp"].t > 10
    assert (found.significant, found.ambiguous) == (True, False)
    assert found.inside.explained > 0.1
    assert found.held.explained > 0
    assert "z depends on temp" in table(found)
    again = gain_on(found, record, al.Recording((WARMING,)))
    assert again.reduction == pytest.approx(found.inside.reduction, rel=1e-9)
    assert again.met
    alone = compensate(record, WARMING, ["temp"], trend=False)
    assert alone["temp"].high < 0
    assert any("rate ramp R" in note and "omit trend=False" in note for note in alone.notes)
    found = compensate(gyro(12, RAMP, model=quiet), WARMING, ["temp"])
    assert not found.significant
    assert "z shows no dependence on temp" in table(found)


def test_a_temperature_that_fits_as_well_as_a_ramp_is_said_to():
    bent = channel(20 + 5 * HOUR / 3600 + 0.02 * np.sin(np.pi * HOUR / 3600))
    for effect in (3e-5 * bent.values, 3e-5 / 720 * HOUR):
        found = compensate(gyro(1, effect), bent, ["temp"])
        assert (found.significant, found.ambiguous) == (False, True)
        assert "the effect of temp can hardly be separated from a rate ramp R" in table(found)
    line = channel(20 + 0.01 * HOUR)
    refused(al.DataError, r"'temp', 'time' are collinear: .* trend=False", lambda: compensate(gyro(1), line, ["temp"]))


def test_a_trend_that_is_left_out_is_said_to_be_confounded():
    warm = channel(20 + 0.002 * HOUR + 0.1 * np.sin(HOUR / 100))
    record = gyro(12, 1e-5 * warm.values)
    alone, both = (compensate(record, warm, ["temp"], trend=trend) for trend in (False, True))
    assert [any("rate ramp R" in note for note in found.notes) for found in (alone, both)] == [True, False]
    assert both["temp"].standard_error > 2 * alone["temp"].standard_error
    assert both["temp"].inflation > 3
    # a drift is never taken off
    assert np.ptp(both.error(record, al.Recording((warm,))) / both["temp"].value - warm.values) < 1e-6


def test_regressors_that_can_hardly_be_told_apart_are_named():
    rng = np.random.default_rng(1)
    twin = channel(TEMP.values + 0.01 * rng.standard_normal(3600), name="twin")
    found = compensate(gyro(13), al.Recording((TEMP, twin)), ["temp", "twin"])
    assert found.condition > 30
    assert any("variance inflation temp" in note for note in found.notes)
    # over a window longer than the record the slope of the temperature is nearly the trend
    i, rng = np.arange(563.0), np.random.default_rng(3)
    bent = 0.13 * i - 1.6e-5 * i**2 + 0.2 * rng.standard_normal(563)
    fast = [al.Record(v, 394.0, u) for v, u in ((1e-3 * rng.standard_normal(563), "rad/s"), (bent, "degC"))]
    found = compensate(fast[0], al.Recording((fast[1],)), [fast[1].name], derivative_of=[fast[1].name])
    assert found.condition > 1000


ALONG = al.Recording((TEMP, channel(np.full(3600, 21.0), name="flat"), channel(2 * TEMP.values, name="double"),
                      al.Record(cycles(360), 0.1, "degC", name="slow"),
                      channel(np.where(HOUR == 7, np.nan, TEMP.values), name="holed")))  # fmt: skip
WRONG = [
    (["flat"], {}, al.DataError, r"'flat' is constant \(always 21 degC\)"),
    (["temp", "double"], {}, al.DataError, "'temp', 'double' are collinear"),
    (["slow"], {}, al.DataError, r"'slow' \(0.1 Hz, 360 samples\) does not have the sample times .*aligned"),
    (["holed"], {}, al.DataError, "1 of its regressors are missing"),
    (["flux"], {}, al.UsageError, "'flux' is missing; channels: temp, flat"),
    ([], {}, al.UsageError, "at least one regressor"), ("temp", {}, al.UsageError, "a sequence of strings"),
    (["temp", "temp"], {}, al.UsageError, "named twice"), (["time"], {}, al.UsageError, "leave out 'time'"),
    (["temp"], {"degree": 0}, al.UsageError, "between 1 and 6"),
    (["temp"], {"lags": (-1.0,)}, al.UsageError, "between 1e-15 and"),
    (["temp"], {"lags": (0.2,)}, al.UsageError, "shorter than the sample interval"),
    (["temp"], {"lags": (4000.0,)}, al.DataError, "longer than"),
    (["temp"], {"settings": FitSettings(least=1e4)}, al.DataError, "effective samples.*least="),
    ([], {"derivative_of": ["temp"], "settings": FitSettings(smooth=10.0)}, al.UsageError, "at least 60 s"),
]  # fmt: skip


@rows("regressors, options, error, words", WRONG)
def test_what_cannot_be_fitted_is_said(regressors, options, error, words):
    refused(error, words, lambda: compensate(gyro(14), ALONG, regressors, **options))


@rows("terms", ["QR", "", "any"])
def test_terms_of_a_fit_are_checked(terms):
    refused(al.UsageError, "noise terms", lambda: FitSettings(terms=terms))


def test_records_that_are_no_use_are_said_to_be():
    refused(al.DataError, "at least 200", lambda: compensate(gyro(1, n=100), channel(cycles(100)), ["temp"]))
    refused(al.DataError, "is constant", lambda: compensate(channel(np.zeros(3600), "deg/s", "z"), TEMP, ["temp"]))
    refused(al.DataError, "'z' explain 'z' completely", lambda: compensate(gyro(1), gyro(1), ["z"]))
    regression, force = compensate(gyro(1), TEMP, ["temp"]), channel(np.zeros(3600), "m/s^2", "a")
    refused(al.UsageError, "no channels were given", lambda: regression.apply(gyro(1)))
    refused(al.UsageError, "belongs to a gyro", lambda: regression.apply(force, al.Recording((TEMP,))))


@pytest.mark.slow("takes more than half a second")
def test_a_cycle_under_a_dominant_walk_is_found():
    """A thermostat: generalised least squares sees it, whatever the walk does between its cycles."""
    cycle = channel(20 + np.sign(np.sin(2 * np.pi * HOUR / 240)))
    walk = al.N(0.1, "deg/sqrt(h)") + al.K(60.0, "deg/h/sqrt(h)")
    slope, every, held = 2e-5, FitSettings(every=True), []
    for seed in range(12):
        quiet, moved = (compensate(gyro(seed, size * cycle.values, model=walk), cycle, ["temp"], settings=every)
                        for size in (0.0, slope))  # fmt: skip
        held.append(moved["temp"].low < slope < moved["temp"].high)
        assert quiet.effective > 10
    assert sum(held) >= 10


def test_units_of_a_regressor_are_converted_but_not_between_zeros():
    def column(values, unit, name="flux", wanted="uT"):
        record = channel(np.zeros(3), "rad/s", "z")
        return Regressor(name, wanted).column(record, al.Recording((channel(values, unit, name),)))

    np.testing.assert_allclose(column([1.0, 2.0, 3.0], "mT"), [1e3, 2e3, 3e3], rtol=1e-12)
    refused(al.UnitError, "their dimensions differ", lambda: column([1.0, 2.0, 3.0], "V"))
    refused(al.UnitError, "whose zeros differ", lambda: column([293.0, 294.0, 295.0], "K", "temp", "degC"))


@given(st.floats(-5, 5), st.floats(60, 200), st.integers(0, 299))
def test_the_slope_of_a_line_is_its_slope_everywhere(slope, window, lost):
    x = slope * np.arange(300.0) + 7
    x[lost] = np.nan
    found = local_slope(x, 1.0, window)
    assert np.isnan(found[lost])
    np.testing.assert_allclose(np.delete(found, lost), slope, atol=1e-9)


def test_the_slope_is_smooth():
    rng = np.random.default_rng(1)
    t = np.arange(2000.0)
    steps = np.round((20 + np.sin(t / 200) + 0.03 * rng.standard_normal(2000)) / 0.0625) * 0.0625
    found = local_slope(steps, 1.0, 120.0)
    assert np.abs(found - np.cos(t / 200) / 200)[60:-60].max() < 0.3 / 200


def test_channels_are_brought_onto_a_clock_only_if_asked():
    def brought(*given, start):
        record = al.Record(np.zeros(8), 2.0, "deg/s", name="z", start=10.0)
        return aligned(al.Recording((al.Record(*given, "V", name="other", start=start),)), record)["other"]

    slow = brought([0.0, 1.0, 2.0, 3.0], 1.0, start=11.0)
    np.testing.assert_allclose(slow.values, [np.nan, np.nan, 0, 0.5, 1, 1.5, 2, 2.5])
    fast = brought(np.arange(40.0), 10.0, start=10.0)
    np.testing.assert_allclose(fast.values, 2 + 5 * np.arange(8.0))
    assert "means" in fast.history[0]
    refused(al.DataError, "do not overlap in time", lambda: brought([1.0, 2.0], 1.0, start=99.0))


def test_the_promise_holds_on_another_record_of_the_same_kind():
    """Outside of 95 % limits with a probability of 5 %: more than 6 of 30 has one of 1e-3."""
    temp = cycles(period=700.0)
    found = compensate(gyro(15, 1e-5 * temp), channel(temp), ["temp"])
    gains = [gain_on(found, gyro(seed, 1e-5 * temp), al.Recording((channel(temp),))) for seed in range(101, 131)]
    assert sum(not gain.met for gain in gains) <= 6
    assert np.mean([g.reduction for g in gains]) == pytest.approx(gains[0].expected, rel=0.1)
    # a record that does not follow the temperature is done harm, and that is not what was promised
    harmed = gain_on(found, gyro(131), al.Recording((channel(temp),)))
    assert harmed.explained < 0
    assert harmed.met is False


def test_a_channel_of_another_kind_goes_along():
    increments = channel(TEMP.values - 20, "m/s", "dv", kind="increment")
    found = compensate(gyro(16, 1e-6 * increments.values), increments, ["dv"])
    assert "per m/s" in found.to_dict()["effects"][0]["unit"]
    assert found["dv"].low < 1e-6 < found["dv"].high


def test_a_study_is_stored_and_drawn(tmp_path):
    record = gyro(5, 1e-5 * TEMP.values)
    al.write(al.Recording((record, TEMP)), tmp_path / "hour.npz")
    settings = al.compensation.CompensationSettings(regressors=("temp",))
    study = al.compensation.compensate_file(tmp_path / "hour.npz", settings=settings)
    assert study.corrected.channels == ("z",)
    again = al.from_dict(json.loads(json.dumps(study.to_dict())))
    refused(al.DataError, "nothing to write", lambda: again.corrected)
    axes = al.plot(study).axes[1]
    before, after, taken = (line.get_xydata() for line in axes.lines)
    assert axes.get_xlabel() == "time (min)"
    assert "means of 9 s" in axes.get_ylabel()
    np.testing.assert_allclose(before[:, 0], (np.arange(400) + 0.5) * 9 / 60)
    np.testing.assert_allclose(before[:, 1] - after[:, 1], taken[:, 1], atol=1e-9)
    means = np.degrees(record.values).reshape(400, 9).mean(axis=1) * 3600
    np.testing.assert_allclose(np.diff(before[:, 1]), np.diff(means), atol=1e-6)
