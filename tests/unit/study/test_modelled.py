"""Plans, checks and state spaces of a recording or of a given model: every form of each, and its recipe."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import paired, refused, rows

import allanite as al
from allanite.reporting import page, table, to_csv
from allanite.study.modelled import PlanSettings, SelfCheckSettings, StateSpaceSettings, run_model_job
from allanite.study.noise import noise_in
from allanite.study.recipe import Recipe

pytestmark = pytest.mark.slow("seconds of analyses")

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


def test_every_form_shows_every_channel_and_the_doubt(job):
    shown, data = page(job), job.to_dict()
    for text in (table(job, width=80), table(job, width=120)):
        assert all(f"\n{name}  gyroscope" in text for name in ("gx", "gy", "gz"))
        assert "not taken into account: " in text
        assert "  ! " in text
    said = " ".join(table(job, width=80).split())
    assert said.count("not explained") == 2  # the grade, and why there is no result
    assert job["gz"].result is None
    assert "To use the coefficients nevertheless: --unexplained" in said or "unexplained=True" in said
    assert 'class="alert"' in shown
    assert (shown.count('class="channel"'), shown.lower().count("not explained") >= 2) == (3, True)
    assert [(c["name"], c["explained"], c["validity"], c["fit"]["type"]) for c in data["channels"]] == [
        ("gx", True, "explained", "Fit"), ("gy", True, "explained", "Fit"), ("gz", False, "unexplained", "Fit"),
    ]  # fmt: skip
    assert {term["status"] for term in data["channels"][2]["fit"]["terms"]} == {"not valid"}
    assert data["channels"][2]["alerts"][0].startswith("not explained")
    assert {row["channel"] for row in csv.DictReader(io.StringIO(to_csv(job)))} == {"gx", "gy"}


@rows("verb", ["plan", "statespace"])
def test_no_number_follows_from_a_rejected_model_unless_it_is_asked_for(verb, file):
    """K = 6944 deg/h/sqrt(h) was planned for a ring laser gyro, and its matrices printed."""
    alone = [verb, file, "--channels", "gz", *OPTIONS[verb]]
    refusal = run(*alone)
    ends(refusal, 3, "gz: not explained")
    assert (refusal.stdout, refusal.stderr.split()[-1]) == ("", "--unexplained")
    asked = json.loads(run(*alone, "--unexplained", "--json", "-", code=0).stdout)
    assert [(channel["explained"], channel["refusal"]) for channel in asked["channels"]] == [(False, "")]
    assert asked["recipe"]["unexplained"] is True


@rows("verb, source", paired(list(OPTIONS), ["file", "sensor"]))
def test_the_recipe_repeats_the_run(verb, source, file, tmp_path):
    noise = (file, "--channels", "gx", "--terms", "NBK") if source == "file" else ("--sensor", "mems", "--rate", 20)
    first = run(verb, *noise, *OPTIONS[verb], "--json", "-", "--report", tmp_path / "page.html", code=0)
    done, recipe = json.loads(first.stdout), tmp_path / "recipe.toml"
    recipe.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in done["recipe"].items()))
    again = run(verb, *noise[: source == "file"], "--recipe", recipe, "--json", "-", code=0)
    assert json.loads(again.stdout) == done
    assert (tmp_path / "page.html").stat().st_size > 5000


def test_what_a_channel_cannot_support_is_said_and_the_others_go_on(tmp_path):
    rng = np.random.default_rng(1)
    models = {"gx": al.N(0.1, "deg/sqrt(h)"), "gy": al.N(0.1, "deg/sqrt(h)") + al.K(200.0, "deg/h/sqrt(h)")}
    white, walk = (al.simulate(model, 4000, 10.0, rng=rng, unit="deg/h", name=name) for name, model in models.items())
    al.write(al.Recording((replace(white, values=np.zeros(4000), name="g0"), white)), tmp_path / "two.npz")
    bad, good = json.loads(run("plan", tmp_path / "two.npz", "--json", "-").stdout)["channels"]
    assert bad["refusal"]
    assert "errors" not in bad
    assert good["names"][0] == "N"
    ends(run("plan", tmp_path / "two.npz"), 0, "no result: ")
    job = run_model_job(al.Recording((white, walk)), StateSpaceSettings())
    words = "only white noise was identified"
    assert job["gx"].refusal.startswith(words)
    assert job["gy"].result.states == ("bias, random walk",)
    refused(al.DataError, words, lambda: run_model_job(white, StateSpaceSettings(), Recipe(terms="N")))
    whole, part = (run_model_job(walk, PlanSettings(), Recipe(band=band))[0].result for band in ("auto", (0.0, 2.0)))
    assert whole.model != part.model


def test_a_check_says_which_limit_it_exceeds(recording):
    job = run_model_job(recording, SETTINGS["selfcheck"])
    assert any(sentence.startswith("gx ") for sentence in job.exceeded)
    assert f"Limit exceeded: {job.exceeded[0].split('+-')[0].strip()}" in page(job)
    refused(al.UsageError, "SelfChecks has no figure", lambda: al.plot(job))


def test_a_term_that_the_curve_contradicts_is_named_as_left_out(recording, monkeypatch):
    def contradicted(*arguments):
        noise = noise_in(*arguments)
        return replace(noise, fit=noise.fit.invalid("it is larger than the curve", ("B",)))

    monkeypatch.setattr("allanite.study.modelled.noise_in", contradicted)
    channel = run_model_job(recording, PlanSettings(), Recipe(channels=("gx",)))[0]
    assert "B" not in {term.symbol for term in channel.result.model}
    said = "B is left out of the model because its coefficient is not valid: it is larger than the curve"
    assert said in channel.alerts
