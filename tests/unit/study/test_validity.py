"""How well a model explains a record: three grades, the same in every form, and cures that work as they are written.

A model that does not explain its record is none of the sensor: what goes on from it refuses it unless told.
"""

import json
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.commands import run
from tests.rows import refused, rows

import allanite as al
from allanite.core.validity import UNEXPLAINED
from allanite.reporting import html_of, page, plot, table
from allanite.study.noise import noise_of
from allanite.study.recipe import Recipe

RATE = 50.0


def record_of(values, name):
    return al.Record(values, RATE, "deg/h", name=name)


def white(seed, size=12_000):
    return np.random.default_rng(seed).standard_normal(size)


@pytest.fixture(scope="module")
def recording():
    """One channel of each grade: white noise, and such that gets a fifth louder, and three times as loud."""
    each = {"good": (1, 1.0), "fair": (2, 1.2), "bad": (3, 3.0)}
    return al.Recording(
        tuple(record_of(white(seed) * np.repeat([1.0, last], 6000), name) for name, (seed, last) in each.items())
    )


@pytest.fixture(scope="module")
def study(recording):
    return al.analyze(recording)


@pytest.fixture(scope="module")
def file(tmp_path_factory, recording):
    path = tmp_path_factory.mktemp("data") / "imu.npz"
    al.write(recording, path)
    return str(path)


GRADES = {"good": "explained", "fair": "approximate", "bad": "unexplained"}


@pytest.mark.slow("takes more than half a second")
def test_the_grade_is_the_same_in_every_form(study):
    data = study.to_dict()
    assert {c["name"]: c["validity"] for c in data["channels"]} == GRADES
    assert {c["name"]: c["fit"]["validity"] for c in data["channels"]} == GRADES
    heads = {"good": "explained (goodness of fit p = ", "fair": "explained, with a reservation (goodness of fit p = ",
             "alert": "not explained: the noise level changes"}  # fmt: skip
    text, shown = table(study), page(study)
    for channel, (level, head) in zip(data["channels"], heads.items(), strict=True):
        assert channel["verdict"].startswith(head)
        assert text.count(f"  {head}") + text.count(f"! {head}") == 1
        assert re.search(rf'<(p|div) class="{level}"[^>]*>(<strong>)?(?i:{re.escape(head)})', shown)
    titles = [re.sub(r", p.*", "", ax.get_title(loc="right")) for ax in plot(study).axes]
    assert titles == ["explained", "explained, with a reservation", "not explained"]
    assert "explained, with a reservation" in html_of(study)


@pytest.mark.slow("seconds of analyses")
def test_what_is_not_valid_is_no_result(study):
    assert {(e.status, e.upper, e.limits) for e in study["bad"].fit} == {("not valid", None, None)}
    rows = [line for line in table(study).splitlines() if re.match(r"  [QNBKR]  .* not valid", line)]
    assert len(rows) >= 5
    assert not any(".." in row or "below" in row for row in rows)
    wrong = table(study["good"].fit.invalid("the curve contradicts it", "N"))
    assert re.search(r"N  angle random walk +\(0\.0023\d+\) +°/√h +not valid", wrong)
    assert "N is not valid: the curve contradicts it" in wrong
    shown = page(study)
    assert 'class="number struck"' in shown
    assert "bad is a gyroscope" not in shown
    assert "not valid: the model does not explain the record" in table(study)


def test_no_model_is_drawn_that_explains_nothing(study):
    good, _, bad = plot(study).axes
    assert ["model" in ax.get_legend_handles_labels()[1] for ax in (good, bad)] == [True, False]
    assert not [text for text in bad.texts if re.match(r"(0\.664 )?[A-Z]+ = ", text.get_text())]
    assert any(re.match(r"N = .*\nat τ = 1 s: .* °/h", text.get_text()) for text in good.texts)


def line_of_the_model(ax):
    return next(line for line in ax.lines if line.get_label() == "model")


def test_a_filter_is_said_and_drawn():
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 20_000, 100.0, rng=1, name="z")
    record = al.simulation.faults.low_pass(record, 12.0)
    study = al.analyze(record, Recipe(terms="QNB"))
    scope = study[0].fit.scope
    assert f"low-pass filtered: {scope.filter.words()}" in " ".join(table(study).split())
    assert "Q not observable: the filter hides" in table(study)
    (ax,) = plot(study).axes
    assert "lowered by the filter" in ax.get_legend_handles_labels()[1]
    assert line_of_the_model(ax).get_xdata()[0] >= scope.times[0]
    (ax,) = plot(al.spectrum(record), study[0].fit).axes
    level = np.interp([1.0, scope.filter.cutoff], *line_of_the_model(ax).get_data())
    assert level[1] / level[0] == pytest.approx(np.sqrt(0.5), rel=0.05)
    assert al.from_dict(json.loads(json.dumps(study.to_dict())))[0].fit.scope.filter == scope.filter


def test_a_band_is_shaded_in_both_figures():
    record = record_of(white(1), "z")
    fit = al.identify(record, band=(0.1, 10.0))
    assert fit.scope.unread == ((0.0, 0.1), (10.0, np.inf))
    curve = al.deviation(record, taus="octave", noise=fit.model)
    for value, edges in ((curve, fit.scope.times), (al.spectrum(record), fit.scope.band)):
        (ax,) = plot(value, fit).axes
        spans = [p.get_extents().transformed(ax.transData.inverted()) for p in ax.patches]
        assert spans
        inner = {round(x, 6) for box in spans for x in (box.x0, box.x1)} & {round(x, 6) for x in edges}
        assert len(inner) == 2


@pytest.mark.slow("takes more than half a second")
@rows(("channels", "code"), [("good,fair", 0), ("good,bad", 3)])
def test_strict_is_an_exit_code(file, channels, code, tmp_path):
    path = tmp_path / "a.json"
    result = run("analyze", file, "--channels", channels, "--strict", "--quiet", "--json", path, code=code)
    assert [c["name"] for c in json.loads(path.read_text())["channels"]] == channels.split(",")
    assert ("not explained, or without a result: bad" in result.stderr) == bool(code)


@pytest.mark.slow("seconds of analyses")
@rows("verb", [
    ("plan",), ("deviation", "--intervals"), ("spectrum", "--fit"), ("statespace",),
    ("rate", "--interval", 2, "--no-times"), ("budget", "--stage", "output 16 100deg/s"),
], ids=lambda verb: verb[0])  # fmt: skip
def test_every_verb_says_the_grade_and_knows_strict(file, verb):
    result = run(verb[0], file, *verb[1:], "--channels", "bad", "--terms", "NB", "--band", "auto", "--strict", code=3)
    text = " ".join(result.output.split())
    assert text.count("not explained: the noise level changes") == 1
    nothing_remains = verb[0] in ("plan", "statespace")
    assert ("without a result: bad" in result.stderr) != nothing_remains


@pytest.mark.slow("two records that no model explains")
def test_strict_refuses_two_records_of_which_one_is_not_explained(tmp_path):
    files = [tmp_path / "8.npz", tmp_path / "9.npz"]
    al.write(record_of(white(8) + 0.3 * np.cumsum(white(18)), "bad"), files[0])
    al.write(record_of(white(9), "bad"), files[1])
    result = run("compare", *files, "--terms", "N", "--band", "all", "--strict", code=3)
    assert "8.npz (not explained), 9.npz (explained)" in " ".join(result.stdout.split())


def test_a_filter_that_was_not_looked_for_is_found_as_the_message_says():
    record = al.simulation.faults.low_pass(record_of(white(1), "z"), 5.0)
    before, after = (noise_of(record, Recipe(terms="QNB", band=band)) for band in ("all", "auto"))
    assert "band='auto'" in before.verdict
    assert "rolls off" in before.verdict
    assert after.explained
    assert "--band" not in after.verdict


def test_outliers_that_were_kept_are_left_out_as_the_message_says():
    values = white(1)
    values[[100, 5000, 9000]] += 60.0
    before, after = (noise_of(record_of(values, "z"), Recipe(terms="N", outliers=way)) for way in ("keep", "mark"))
    assert "prepare.mark_outliers" in before.verdict
    assert after.validity == "explained"


def test_heavy_tails_without_outliers_name_no_cure_that_was_taken():
    values = white(1)
    values[::200] *= 8
    for outliers in ("keep", "mark"):
        noise = noise_of(record_of(values, "z"), Recipe(terms="N", outliers=outliers))
        assert noise.validity == "approximate"
        assert "the intervals of the fast noise are widened for them" in noise.verdict
        assert "--" not in noise.verdict


def test_parts_of_another_level_are_explained_apart_as_the_message_says(file):
    told = run("analyze", file, "--channels", "fair", "--terms", "N").stdout
    named = re.search(r"analyze the parts separately \((.*?)\)", " ".join(told.split()))[1]
    for cut in (("--until", 120), ("--from", 120), named.split()):
        result = run("analyze", file, "--channels", "fair", "--terms", "N", *cut, "--json", "-")
        assert json.loads(result.stdout)["channels"][0]["validity"] == "explained"


def test_readings_too_coarse_are_told_without_a_p_value():
    record = record_of(np.round(0.3 * white(1)), "z")
    noise = noise_of(record, Recipe(terms="N"))
    assert noise.validity == "unexplained"
    assert "p =" not in noise.statement.head
    assert "p =" not in table(al.analyze(record, Recipe(terms="N"))).split("read off")[0]


@pytest.mark.slow("takes more than half a second")
def test_a_model_whose_deviation_is_nowhere_that_of_the_record_explains_nothing(monkeypatch):
    """It was "explained up to 0 s"."""
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 20_000, 10.0, rng=1)
    monkeypatch.setattr("allanite.study.noise.held", lambda fit, record: 0.0)
    channel = al.analyze(record)[0]
    assert not channel.explained
    assert "is that of the record at no averaging time" in channel.verdict
    assert "0 s" not in channel.verdict
    assert channel.fit["N"].status == "not valid"


TRUTH = al.Model("N 0.5 deg/sqrt(h), B 30 deg/h, K 900 deg/h/sqrt(h)")
RECORD = al.simulate(TRUTH, 20_000, RATE, rng=4, name="gx")
FIT = al.identify(RECORD)
REJECTED = replace(FIT, checked=UNEXPLAINED)
TILT = al.Model("N 100 ug/sqrt(Hz)")

USES = {
    "plan": lambda noise: al.plan(noise, RATE, durations=(600.0,)),
    "bound": lambda noise: al.bound(noise, 5000, RATE),
    "simulate": lambda noise: al.simulate(noise, 500, RATE, rng=1),
    "selfcheck": lambda noise: al.selfcheck(noise, 500, RATE, records=2, rng=1),
    "state space": lambda noise: al.state_space(noise, RATE),
    "drift": al.drift,
    "export": lambda noise: al.export(noise, "statespace", rate=RATE),
    "rate": lambda noise: al.constant_rate.estimate(RECORD, "mean", model=noise),
    "rates": lambda noise: al.constant_rate.experiment(
        RECORD, noise, al.constant_rate.ExperimentSettings(interval=20.0, methods=("mean",))
    ),
    "ranking": lambda noise: al.constant_rate.rank(noise, size=500, rate=RATE),
    "prediction": lambda noise: al.constant_rate.predicted_standard_error("mean", noise, size=500, rate=RATE),
    "vertical": lambda noise: al.attitude.optimal_time_constant(noise, TILT, duration=600.0),
}
"""What takes a noise and goes on from it."""


@pytest.mark.slow("seconds of analyses")
@rows("use", USES)
def test_what_goes_on_from_a_noise_refuses_one_that_explains_nothing(use):
    for noise in (REJECTED, REJECTED.model):
        refused(al.DataError, "does not explain the record", lambda noise=noise: USES[use](noise))
    for noise in (FIT, REJECTED.model.usable(unexplained=True)):
        assert USES[use](noise) is not None


@pytest.mark.slow("seconds of analyses")
def test_pulses_of_a_dithered_ring_laser_have_no_model_from_the_samples():
    record = al.simulation.simulate_ring_laser(al.simulation.GL1, 12.4392, 24_000, 400.0, rng=3)
    use = {"method": "optimal", "model": al.identify(record)}
    refused(al.DataError, "does not explain the record", lambda: al.constant_rate.estimate(record, **use))


def test_what_is_not_valid_is_left_out_of_a_fit_and_its_model_is_refused():
    fit = FIT.invalid("the curve contradicts it", ("K",))
    assert "K" in {term.symbol for term in fit.model}
    assert [t.symbol for t in fit.usable()] == [t.symbol for t in fit.model if t.symbol != "K"]
    assert fit.usable() == fit.valid
    refused(al.DataError, "not valid in this model: K", lambda: al.bound(fit.model, 5000, RATE))
    assert al.bound(fit, 5000, RATE).names == al.bound(fit.usable(), 5000, RATE).names


def test_a_doubt_goes_where_the_model_goes_and_changes_nothing_else():
    model = REJECTED.model
    assert model.doubt
    assert (model, repr(model)) == (FIT.model, repr(FIT.model))
    copies = [pickle.loads(pickle.dumps(model)), al.Model.from_dict(model.to_dict()), replace(model), model.noise]
    copies += [model + al.W(1, "deg/h", time_constant=20), al.W(1, "deg/h", time_constant=20) + model]
    assert [copy.doubt for copy in copies] == [model.doubt] * len(copies)
    assert pickle.loads(pickle.dumps(REJECTED)).model.doubt == al.Fit.from_dict(REJECTED.to_dict()).model.doubt != ""
    assert al.Model(model.terms).doubt == TRUTH.doubt == ""
    assert "doubt" not in TRUTH.to_dict()
    assert replace(REJECTED, checked="").model.doubt == FIT.model.doubt == ""


def test_curves_still_show_what_a_rejected_model_predicts():
    curve = al.deviation(RECORD, "oadev", noise=REJECTED)
    assert np.isfinite(curve.interval()[0]).all()
    assert al.expected(REJECTED.model, "oadev", [1.0]) == pytest.approx(al.expected(FIT.model, "oadev", [1.0]))
