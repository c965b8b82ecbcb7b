"""Plans, checks and state spaces of a recording or of a given model: every form of each, and its recipe."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from tests.commands import run
from tests.rows import paired, rows

import allanite as al
from allanite.reporting import page, table, to_csv
from allanite.study.modelled import PlanSettings, SelfCheckSettings, StateSpaceSettings, run_model_job
from allanite.study.noise import noise_in
from allanite.study.recipe import Recipe

SETTINGS = {
    "plan": PlanSettings(durations=(600.0, 7200.0), accuracy=0.07),
    "selfcheck": SelfCheckSettings(records=3, samples=1000, max_bias=1e-8),
    "statespace": StateSpaceSettings(tau=(1.0, 100.0), ripple=0.03, turn_on="3 deg/h"),
}
OPTIONS = {
    "plan": ("--durations", "10 min,2h", "--accuracy", 7),
    "selfcheck": ("--records", 3, "--samples", 1000),
    "statespace": ("--tau", "1,100", "--ripple", 3, "--turn-on", "3 deg/h"),
}


@pytest.fixture(scope="module")
def recording():
    """Two channels that the terms explain, and one that gets three times as loud, which they do not."""
    rng = np.random.default_rng(1)
    x, y, z = (al.simulate(al.sensor("mems"), 20_000, 20.0, rng=rng, unit="deg/h", name=f"g{c}") for c in "xyz")
    louder = z.values * np.repeat([1.0, 3.0], z.size // 2)
    return al.Recording((x, y, z.with_values(louder, "louder from the middle on")))


@pytest.fixture(scope="module")
def file(tmp_path_factory, recording):
    path = tmp_path_factory.mktemp("data") / "imu.npz"
    al.write(recording, path)
    return str(path)


@pytest.fixture(scope="module", params=list(SETTINGS))
def job(request, recording):
    return run_model_job(recording, SETTINGS[request.param], Recipe())


@pytest.mark.slow("takes more than half a second")
def test_every_form_shows_every_channel_and_the_doubt(job):
    assert [channel.name for channel in job.channels] == ["gx", "gy", "gz"]
    shown = page(job)
    for text in (table(job, width=80), table(job, width=120)):
        assert all(f"\n{name}  gyroscope" in text for name in ("gx", "gy", "gz"))
        assert "not taken into account: " in text
        assert "  ! " in text
    said = " ".join(table(job, width=80).split())
    assert said.count("not explained") == 2  # the grade, and why there is no result
    assert job["gz"].result is None
    assert "To use the coefficients nevertheless: --unexplained" in said or "unexplained=True" in said
    assert 'class="alert"' in shown
    assert shown.count('class="channel"') == 3
    data = job.to_dict()
    assert [c["explained"] for c in data["channels"]] == [True, True, False]
    assert [c["validity"] for c in data["channels"]] == ["explained", "explained", "unexplained"]
    assert {term["status"] for term in data["channels"][2]["fit"]["terms"]} == {"not valid"}
    assert data["channels"][2]["alerts"][0].startswith("not explained")
    assert shown.lower().count("not explained") >= 2
    assert [c["fit"]["type"] for c in data["channels"]] == ["Fit"] * 3
    rows = list(csv.DictReader(io.StringIO(to_csv(job))))
    assert {row["channel"] for row in rows} == {"gx", "gy"}


@pytest.mark.slow("takes more than half a second")
@rows("verb", ["plan", "statespace"])
def test_no_number_follows_from_a_rejected_model_unless_it_is_asked_for(verb, file):
    """K = 6944 deg/h/sqrt(h) was planned for a ring laser gyro, and its matrices printed."""
    alone = [verb, file, "--channels", "gz", *OPTIONS[verb]]
    refused = run(*alone)
    assert (refused.exit_code, refused.stdout) == (3, "")
    assert "gz: not explained" in refused.stderr
    assert refused.stderr.rstrip().endswith("To use the coefficients nevertheless: --unexplained")
    asked = run(*alone, "--unexplained", "--json", "-", code=0)
    (channel,) = json.loads(asked.stdout)["channels"]
    assert (channel["explained"], channel["refusal"]) == (False, "")
    assert json.loads(asked.stdout)["recipe"]["unexplained"] is True


def test_a_check_has_no_figure(recording):
    with pytest.raises(al.UsageError, match="SelfChecks has no figure"):
        al.plot(run_model_job(recording.records[0], SETTINGS["selfcheck"]))


@pytest.mark.slow("seconds of analyses")
@rows("verb, source", paired(list(OPTIONS), ["file", "sensor"]))
def test_the_recipe_repeats_the_run(verb, source, file, tmp_path):
    noise = (file, "--channels", "gx", "--terms", "NBK") if source == "file" else ("--sensor", "mems", "--rate", 20)
    first = run(verb, *noise, *OPTIONS[verb], "--json", "-", "--report", tmp_path / "page.html", code=0)
    found = json.loads(first.stdout)
    recipe = tmp_path / "recipe.toml"
    recipe.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in found["recipe"].items()))
    again = run(verb, *noise[: source == "file"], "--recipe", recipe, "--json", "-", code=0)
    assert json.loads(again.stdout) == found
    assert (tmp_path / "page.html").stat().st_size > 5000


@pytest.mark.slow("seconds of analyses")
@rows("verb", ["plan", "statespace"])
def test_the_options_of_the_identification_work(verb, file):
    """A band on a recording gives other numbers than the whole record."""
    usual = [verb, file, "--channels", "gx", "--json", "-", *OPTIONS[verb]]
    band = [*usual, "--band", "0,2"]
    (whole,), (part,) = (json.loads(run(*words).stdout)["channels"] for words in (usual, band))
    assert whole["model"] != part["model"]


def test_what_a_channel_cannot_support_is_said_and_the_others_go_on(tmp_path):
    rng = np.random.default_rng(1)
    models = (al.N(0.1, "deg/sqrt(h)"), al.N(0.1, "deg/sqrt(h)") + al.K(200.0, "deg/h/sqrt(h)"))
    white, walk = (al.simulate(model, 4000, 10.0, rng=rng, unit="deg/h", name="g") for model in models)
    constant = replace(white, values=np.zeros(4000), name="g0")
    al.write(al.Recording((constant, replace(white, name="gx"))), tmp_path / "two.npz")
    refused, good = json.loads(run("plan", tmp_path / "two.npz", "--json", "-").stdout)["channels"]
    assert refused["refusal"]
    assert "errors" not in refused
    assert good["names"][0] == "N"
    assert "no result: " in run("plan", tmp_path / "two.npz").stdout
    job = run_model_job(al.Recording((replace(white, name="gx"), replace(walk, name="gy"))), StateSpaceSettings())
    assert job["gx"].refusal.startswith("only white noise was identified")
    assert job["gy"].result.states == ("bias, random walk",)
    with pytest.raises(al.DataError, match="only white noise was identified"):
        run_model_job(white, StateSpaceSettings(), Recipe(terms="N"))


@pytest.mark.slow("takes more than half a second")
def test_a_check_says_which_limit_it_exceeds(recording):
    job = run_model_job(recording, SETTINGS["selfcheck"])
    assert any(sentence.startswith("gx ") for sentence in job.exceeded)
    assert f"Limit exceeded: {job.exceeded[0].split('+-')[0].strip()}" in page(job)


@pytest.mark.slow("takes more than half a second")
def test_a_term_that_the_curve_contradicts_is_named_as_left_out(recording, monkeypatch):
    def contradicted(*arguments):
        noise = noise_in(*arguments)
        return replace(noise, fit=noise.fit.invalid("it is larger than the curve", ("B",)))

    monkeypatch.setattr("allanite.study.modelled.noise_in", contradicted)
    found = run_model_job(recording, PlanSettings(), Recipe(channels=("gx",)))[0]
    assert "B" not in {term.symbol for term in found.result.model}
    said = "B is left out of the model because its coefficient is not valid: it is larger than the curve"
    assert said in found.alerts
