"""The command line that the page shows is text that says the same as the request."""

import shlex

import click
import pytest
from tests.rows import rows

import allanite as al
from allanite.cli import jobs, main, task_of
from allanite.cli.deliver import recipe_of, settings_of
from allanite.core.choices import choices_of
from allanite.study.settings import DensityChoices, DeviationChoices
from allanite.web.requests import Request, accepted, problem_of

RECIPE = {
    "rate": 100, "unit": {"gyro": "deg/s", "accel": "g"}, "kind": "rate", "channels": ["gx", "2"], "time": "stamp[us]",
    "exclude": [[40, 60.5], [1e-3, 2]], "start": 1 / 3, "until": "900", "outliers": "mark", "memory": "1GB",
}  # fmt: skip
IDENTIFYING = {"terms": "NBK", "method": "piecewise", "ranges": {"N": [0.1, 10]}, "band": [0.1, 5], "mask": "1..2"}

REQUESTS = [
    ("info", {**RECIPE, "scale": "0.01deg/s", "unit": None}),
    ("analyze", {**RECIPE, **IDENTIFYING, "statistic": "mdev", "taus": [1, 10], "level": 0.68, "to": ["deg/s"]}),
    ("analyze", {"about": ["serial=SN 12", "operator=it's me"], "device": "fog", "average": 0.1, "quiet_window": 60}),
    ("deviation", {"statistic": ["adev", "theo1"], "bias": "plain", "intervals": False, "power_law": True, "m": "1,2"}),
    ("deviation", {"taus": "all", "join": 0.15, "divisor": 6, "edf": "published", "to": "deg/h"}),
    ("spectrum", {"estimator": "multitaper", "tapers": 5, "fit": True, "bins": 0, "band": "all"}),
    ("dynamic", {"rate": "50", "window": 600, "step": 60.5, "taus": [1.5, 3], "level": 0.9}),
    ("compare", {"against": ["gz"], "channels": "gx", "taus": "log"}),
    ("compare", {"part": 80, "taus": "octave"}),
    ("watch", {"rate": 100, "unit": "deg/h", "every": "1 min", "duration": 3600, "baud": 9600, "accuracy": 0.07}),
]


@rows(("verb", "data"), REQUESTS)
def test_the_line_of_a_request_is_parsed_back_to_equal_values(verb, data):
    request = Request.of(verb, data)
    _, *words = shlex.split(request.line(["-my file.csv"], "ru"))
    with click.Context(main, **main.context_settings) as above:
        command = main.get_command(above, verb)
    with command.make_context(verb, words[1:], parent=above) as context:
        choices = dict(context.params)
    task = task_of(verb)
    settings = settings_of(task.kind, choices) if task.kind else None
    assert (settings, recipe_of(choices, **task.usual)) == (request.settings, request.recipe)
    assert choices["lang"] == "ru"
    assert "-my file.csv" in str(context.params.values())


@rows("verb", jobs())
def test_what_is_usual_is_not_said(verb):
    assert Request.of(verb, dict.fromkeys(accepted(verb), "")).line(["x.csv"]) == f"allanite {verb} x.csv"
    assert Request.of("analyze", {"start": []}).recipe == al.Recipe()


@rows("data, option, words", [
    ({"rate": "fast"}, "rate", "Invalid value for '--rate' / '--fs': expected a number, not 'fast'"),
    ({"level": 95}, "level", "a confidence level must be between 0 and 1, not 95"),
    ({"channels": 7}, "channels", "Invalid value for '--channels': expected names, e.g. gx,gy, not 7"),
    ({"band": "3"}, "band", "Invalid value for '--band': expected auto, all, or two frequencies in Hz"),
    ({"ranges": "N=1"}, "ranges", "Invalid value for '--ranges': expected terms with their ranges"),
    ({"columns": "six"}, "columns", "expected an integer, not 'six'"),
    ({"kind": "speed"}, "kind", "unknown kind 'speed'"),
    ({"nonsense": 1}, None, "unknown key 'nonsense' in the recipe; known keys: rate, unit"),
])  # fmt: skip
def test_a_refusal_names_its_choice(data, option, words):
    with pytest.raises(al.UsageError) as refused:
        Request.of("analyze", data)
    problem = problem_of(refused.value)
    assert words in problem["error"]
    assert (problem["option"], problem["exit"]) == (option, 2)


def test_choices_are_stated_once():
    # a choice of several classes has the same option and help
    rows = [choices_of(kind) for kind in (DensityChoices, DeviationChoices)]
    assert rows[0]["to"].text == rows[1]["to"].text
    assert all(row.help and row.group for row in choices_of(al.Recipe).values())
