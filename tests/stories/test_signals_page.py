"""What the pages on compensation and on currents show is run."""

import json
import re

import numpy as np
import pytest
from tests.pages import commands, fenced, stated, text_of, typed
from tests.rows import rows

import allanite as al

PAGES = ("budget.md", "compensation.md")
PAGE = "\n".join(map(text_of, PAGES))
PROGRAMS = [block for page in PAGES for block in fenced(page, "python")]
COMMANDS = [line for page in PAGES for line in commands(page)]


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A week of a gyro with a thermometer, and a voltage."""
    folder = tmp_path_factory.mktemp("week")
    model = al.N(0.1, "deg/sqrt(h)") + al.K(1.0, "deg/h/sqrt(h)")
    t = np.arange(1800)
    for seed, day in enumerate(("monday", "tuesday", "wednesday"), 1):
        rng = np.random.default_rng(seed)
        temp = 25 + 5 * np.sin(t / 300 + seed)
        gx = np.degrees(al.simulate(model, t.size, 1.0, rng=rng).values) * 3600 + 3 * temp
        rows = np.column_stack([t, gx, temp])
        np.savetxt(folder / f"{day}.csv", rows, "%.9g", ",", header="time [s],gx [deg/h],temp [degC]", comments="")
    chamber = np.sin(np.arange(3600) / 400)
    axes = [np.degrees(al.simulate(model, 3600, 1.0, rng=rng).values) * 3600 + 90 * chamber**k for k in (1, 2, 3)]
    rows, header = np.column_stack([np.arange(3600), *axes, 40 + 25 * chamber]), "gx [deg/h],gy [deg/h],gz [deg/h]"
    np.savetxt(folder / "soak.csv", rows, "%.9g", ",", header=f"time [s],{header},temp [degC]", comments="")
    volts = 5 * al.simulate(al.N(2.5, "deg/sqrt(h)"), 5000, 1000.0, rng=np.random.default_rng(4)).values / 0.2
    rows = np.column_stack([np.arange(5000) / 1000, volts])
    np.savetxt(folder / "current.csv", rows, ["%.3f", "%.10g"], ",", header="time [s],ux [V]", comments="")
    return folder


@pytest.mark.slow("seconds of analyses")
@rows("block", PROGRAMS, ids=range(len(PROGRAMS)))
def test_python_prints_what_it_says(block, capsys):
    exec(block, {"__name__": "__main__"})  # noqa: S102 - our own page
    assert capsys.readouterr().out.splitlines() == stated(block) != []


@pytest.mark.slow("takes more than half a second")
def test_commands_run_one_after_the_other(desk, monkeypatch):
    monkeypatch.chdir(desk)
    assert len(COMMANDS) == 10
    for command in COMMANDS:
        typed(command, writing=("--report", "--save", "--corrected", "--output"))


TURNED = [line for line in COMMANDS if "up." in line or "down." in line]
"""From two currents in each of two positions to rates without bias."""


@pytest.mark.slow("takes more than half a second")
@pytest.mark.usefixtures("details")
def test_two_positions_remove_the_bias_of_both_axes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in TURNED:
        said = typed(command, writing=())
    assert "rate by reversal: 28.9 (" in said
    assert "bias by reversal: 12.4 (" in said
    channels = json.loads(typed(TURNED[-1], "--until", "300", "--json", "-", writing=()))["channels"]
    assert [channel["name"] for channel in channels] == ["wx", "wy"]
    for channel, sign in zip(channels, (-1, 1), strict=True):
        for found, truth in ((channel["estimates"][0], 28.878), (channel["bias"], 12.376)):
            keys = ("value", "low", "high", "standard_error")
            value, low, high, error = (np.degrees(found[key]) * 3600 for key in keys)
            assert low < sign * truth < high
            assert value != pytest.approx(sign * truth, abs=0.1)  # five minutes have an error
            assert error == pytest.approx(2.544 * 60 / 600**0.5, rel=0.05)


def test_the_figures_of_the_page_are_those_of_the_formula():
    rows = re.findall(r"^\| ±(\d+) \| ([\d.]+) \| ([\d.]+) % \|$", PAGE, re.MULTILINE)
    assert [float(row[0]) for row in rows] == [10, 100, 500]
    for scale, n, share in rows:
        adds = 60 * al.signals.Stage("ADC", 12, float(scale), "deg/s").step / 12**0.5 * 1e-3**0.5
        assert float(n) == pytest.approx(adds, rel=0.02)
        assert float(share) == pytest.approx(100 * (adds / 2.525648) ** 2, rel=0.2)
