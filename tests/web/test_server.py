"""The server of the page: its jobs are those of the command line, and what it keeps outlives it."""

import json
import os
import signal
from contextlib import suppress
from glob import glob

import numpy as np
import pytest
from tests import translated
from tests.commands import run
from tests.rows import rows

import allanite as al
from allanite.core.choices import choices_of
from allanite.phrases.phrase import say
from allanite.reporting.digits import printed_unit

from .served import Client, served, waiting_job

pytestmark = pytest.mark.slow("the page without a browser")

RATE = 100.0


@pytest.fixture(scope="module")
def link(folder):
    with served(folder, "--limit", "3MB", "--quota", "60MB", waiting=True) as (_, link):
        yield link


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Two gyros without a time column; the first is disturbed for 20 s."""
    rng = np.random.default_rng(1)
    data = rng.normal(0.0, 2.0, (20_000, 2))
    data[4000:6000, 0] += rng.normal(0.0, 10.0, 2000)
    path = tmp_path_factory.mktemp("data") / "gyro.csv"
    np.savetxt(path, data, delimiter=",", fmt="%.6g", header="gx [deg/h],gy [deg/h]", comments="")
    return path


@pytest.fixture(scope="module")
def analyzed(client, file):
    workspace = client.workspace()
    job, last = client.run(workspace, "analyze", [client.upload(workspace, file)], {"rate": RATE, "exclude": "40..60"})
    assert last == ("done", {"exit": 0})
    return job


def printed(*words):
    return run(*words, code=0).stdout


def test_the_json_and_the_saved_recipe_are_those_of_the_command_line(client, analyzed, file, tmp_path):
    found = client.get(f"/api/jobs/{analyzed}").json()
    assert found["command"] == "allanite analyze --rate 100 --exclude 40..60 gyro.csv"
    data = json.loads(printed("analyze", file, "--rate", "100", "--exclude", "40..60", "--json", "-"))
    ours = found["value"]
    assert ours["provenance"].pop("source") == "gyro.csv"
    assert data["provenance"].pop("source") == str(file)
    assert ours == data
    assert "excluded: 40 s to 60 s" in json.dumps(ours)
    # the saved recipe gives the same
    recipe = tmp_path / "recipe.toml"
    recipe.write_bytes(client.get(f"/api/jobs/{analyzed}/save", form="recipe").content)
    data = json.loads(printed("analyze", file, "--recipe", recipe, "--json", "-"))
    saved = client.get(f"/api/jobs/{analyzed}/save", form="json").json()
    assert saved["channels"] == data["channels"]


def test_the_words_and_files_are_those_of_the_command_line(client, analyzed, file):
    one = client.get(f"/api/jobs/{analyzed}").json()["channels"][0]
    assert "angle random walk" in one["html"]
    assert "style=" not in one["html"]
    assert [seen["at"] for seen in one["findings"] if seen["name"] == "gaps"] == [[40.0, 60.0]]
    russian = client.get(f"/api/jobs/{analyzed}", lang="ru").json()["channels"][0]
    assert translated(say("angle random walk"), "ru") in russian["html"]
    # a file for a filter is that of the command line
    found = client.post(f"/api/jobs/{analyzed}/export", {"channels": ["gy"], "target": "datasheet"}).json()
    options = ("--rate", "100", "--exclude", "40..60", "--channels", "gy", "--to", "datasheet", "--output", "-")
    assert found["text"] == printed("export", file, *options).replace(str(file), "gyro.csv")
    whole = {"channels": ["gy"], "target": "kalibr", "models": ["N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)"], "cover": False}
    assert "gyroscope_noise_density" in client.post(f"/api/jobs/{analyzed}/export", whole).json()["html"]
    refused = client.post(f"/api/jobs/{analyzed}/export", {"target": "nonsense"})
    assert refused.json()["error"].startswith("unknown target 'nonsense'; known targets: kalibr")


def test_curves_have_bands_a_model_and_its_terms_and_traces_every_extreme(client, analyzed, file):
    found = client.get(f"/api/jobs/{analyzed}/deviation", channel="gy", statistic="oadev").json()
    stored = client.get(f"/api/jobs/{analyzed}").json()["value"]["channels"][1]
    curve, fit = stored["curves"][0], stored["fit"]
    assert found["unit"] == printed_unit("deg/h")
    scale = np.radians(1 / 3600)
    np.testing.assert_allclose(found["deviation"], np.array(curve["deviation"]) / scale)
    np.testing.assert_allclose(found["low"], np.array(curve["low"]) / scale)
    assert {term["symbol"] for term in found["terms"]} <= {term["symbol"] for term in fit["terms"]}
    whole = sum(np.array(term["deviation"]) ** 2 for term in found["terms"])
    np.testing.assert_allclose(whole, np.array(found["model"]["deviation"]) ** 2, rtol=1e-6)
    guide = next(one for one in found["guides"] if one["symbol"] == "N")
    # N of 1 deg/sqrt(h) makes 60 deg/h at 1 s
    np.testing.assert_allclose(np.array(guide["deviation"]) * np.sqrt(guide["tau"]), 60.0, rtol=1e-9)
    other = client.get(f"/api/jobs/{analyzed}/deviation", channel="gy", statistic="mdev").json()
    assert other["statistic"] == "mdev"
    assert other["low"][3] < other["deviation"][3] < other["high"][3]
    # the trace has every extreme
    uploaded = client.get(f"/api/jobs/{analyzed}").json()["files"][0]
    data = np.loadtxt(file, delimiter=",", skiprows=1)[:, 0]
    whole = client.get(f"/api/files/{uploaded}/trace", channel="gx", points=100).json()
    assert (min(whole["low"]), max(whole["high"])) == pytest.approx((data.min(), data.max()), rel=1e-5)
    close = client.get(f"/api/files/{uploaded}/trace", channel="gx", points=100, **{"from": 10, "to": 10.5}).json()
    np.testing.assert_allclose(close["low"], data[1000:1050], rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(close["t"], np.arange(1000, 1050) / RATE)
    assert client.get(f"/api/files/{uploaded}/trace", channel="gz").json()["error"].startswith("no channel 'gz'")


def test_a_refit_is_what_the_command_line_fits(client, analyzed, file):
    asked = {"channel": "gy", "terms": "NK", "band": [0.1, 40], "statistics": ["oadev"]}
    found = client.post(f"/api/jobs/{analyzed}/refit", asked).json()
    line = ("--rate", "100", "--exclude", "40..60", "--terms", "NK", "--band", "0.1,40", "--channels", "gy")
    data = json.loads(printed("analyze", file, *line, "--json", "-"))
    assert [t["value"] for t in found["fit"]["terms"]] == [t["value"] for t in data["channels"][0]["fit"]["terms"]]
    assert found["curve"][0]["terms"]
    assert "random walk" in found["html"]


def test_the_first_curve_comes_before_the_result(client, file):
    workspace = client.workspace()
    job = client.begin(workspace, "analyze", [client.upload(workspace, file)], {"rate": RATE, "channels": ["gy"]})
    events = dict(client.events(job))
    (first,) = events["curves"]["channels"]
    assert list(events)[-1] == "done"
    stored = client.get(f"/api/jobs/{job}/deviation", channel="gy", statistic="oadev").json()
    assert (first["name"], first["unit"], first["low"]) == ("gy", stored["unit"], None)
    assert first["deviation"][0] == pytest.approx(stored["deviation"][0], rel=1e-12)


@rows(
    ("form", "begins"),
    [("report", b"<!DOCTYPE html>"), ("csv", b"channel,"), ("figure.png", b"\x89PNG"), ("coefficients", b"channel,")],
)
def test_results_are_saved(client, analyzed, form, begins):
    answer = client.get(f"/api/jobs/{analyzed}/save", form=form)
    assert answer.headers["content-disposition"].startswith("attachment; filename=")
    assert answer.content.startswith(begins)


@rows(
    ("recipe", "option"),
    [
        ({}, "rate"), ({"rate": "fast"}, "rate"), ({"rate": RATE, "unit": "parsec"}, "unit"),
        ({"rate": RATE, "level": 95}, "level"), ({"rate": RATE, "band": "3"}, "band"),
        ({"rate": RATE, "exclude": "60..40"}, "exclude"), ({"rate": RATE, "exclude": [[100, 900]]}, None),
        ({"rate": RATE, "terms": "XY"}, "terms"), ({"rate": RATE, "channels": ["gz"]}, "channels"),
        ({"rate": RATE, "method": "magic"}, "method"), ({"rate": RATE, "start": 50, "until": 40}, None),
    ],
)  # fmt: skip
def test_bad_input_has_the_words_of_the_command_line_and_its_control(client, file, recipe, option):
    workspace = client.workspace()
    answer = client.ask(workspace, "analyze", [client.upload(workspace, file)], recipe)
    problem = answer.json() if answer.status_code == 400 else list(client.events(answer.json()["job"]))[-1][1]
    words = [word for key, value in recipe.items() for word in choices_of(al.Recipe)[key].words(value)]
    said = run("analyze", *words, file)
    assert said.exit_code == problem["exit"]
    words = said.stderr.replace(str(file), "gyro.csv")
    assert "".join(words.split()).startswith("".join(f"error:{problem['error']}".split()))
    if option is not None:
        assert problem["option"] == option


def test_two_files_with_the_same_samples_are_not_compared(client, file):
    workspace = client.workspace()
    files = [client.upload(workspace, file, name) for name in ("before.csv", "after.csv")]
    _, (kind, problem) = client.run(workspace, "compare", files, {"rate": RATE, "channels": ["gy"]})
    assert kind == "failed"
    assert "identical" in problem["error"]


SURVEYS = [(verb, {"start": 80, "until": 180}, "Survey") for verb in ("spectrum", "dynamic", "deviation")]


@rows("verb, recipe, kind", [("compare", {"part": 80, "channels": ["gy"]}, "Comparison"), *SURVEYS])
def test_a_file_is_compared_with_itself_and_has_its_spectrum_and_surface(client, file, verb, recipe, kind):
    workspace = client.workspace()
    job, last = client.run(workspace, verb, [client.upload(workspace, file)], {"rate": RATE} | recipe)
    assert last[0] == "done"
    value = client.get(f"/api/jobs/{job}").json()["value"]
    assert (value["type"], len(value["channels"])) == (kind, 2 - (verb == "compare"))


def holders(path):
    """Other processes that have opened a file."""
    for link in glob("/proc/[0-9]*/fd/*"):
        with suppress(OSError):
            pid = int(link.split("/")[2])
            if os.readlink(link) == str(path) and pid != os.getpid():
                yield pid


@rows("killed", [False, True])
def test_a_job_ends_at_once_in_a_sentence_and_the_next_one_runs(client, file, tmp_path, killed):
    with waiting_job(client, tmp_path) as (workspace, job):
        if killed:
            for pid in set(holders(tmp_path / "pipe")):
                os.kill(pid, signal.SIGKILL)
        else:
            client.post(f"/api/jobs/{job}/cancel")
        kind, problem = list(client.events(job))[-1]
        if killed:
            assert problem["error"].startswith("the process of this job was ended by signal 9")
            assert "--channels" in problem["error"]
        else:
            assert problem == {"error": "cancelled", "option": None, "exit": 130}
        assert kind == "failed"
        assert client.get(f"/api/jobs/{job}").json()["state"] == ("failed" if killed else "cancelled")
        _, last = client.run(workspace, "info", [client.upload(workspace, file)], {"rate": RATE})
        assert last[0] == "done"


def test_a_server_that_is_killed_goes_on_after_a_restart(tmp_path, file):
    with served(tmp_path) as (process, link), Client(link) as client:
        workspace = client.workspace()
        uploaded = client.upload(workspace, file)
        done, _ = client.run(workspace, "analyze", [uploaded], {"rate": RATE, "channels": ["gy"]})
        client.http.put(f"/api/workspaces/{workspace}/choices", json={"cut": [40, 60]})
        before = client.get(f"/api/jobs/{done}").content
        unfinished = client.begin(workspace, "analyze", [uploaded], {"rate": RATE})
        process.kill()
        process.wait()
    with served(tmp_path) as (_, link), Client(link) as client:
        state = client.get(f"/api/workspaces/{workspace}").json()
        assert state["choices"] == {"cut": [40, 60]}
        assert [one["name"] for one in state["files"]] == ["gyro.csv"]
        assert client.get(f"/api/jobs/{done}").content == before
        assert list(client.events(unfinished))[-1] == ("done", {"exit": 0})
        # what needs the samples reads them again
        again = client.post(f"/api/jobs/{done}/refit", {"channel": "gy", "terms": "N"})
        assert again.status_code == 200, again.text
