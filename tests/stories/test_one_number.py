"""N and the in-run stability of a channel are the same, to the last printed digit, in every verb and form."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import allanite as al
from allanite.cli import main
from allanite.core.digits import digits

LIMITS = '[limits]\nN = { max = "0.001 deg/sqrt(h)" }\nminimum = { max = "0.001 deg/h" }\n'
VERBS = {
    "analyze": "analyze gyro.csv", "details": "analyze gyro.csv --details", "export": "export gyro.csv",
    "several": "analyze gyro.csv other.csv", "lot": "lot results", "watch": "watch gyro.csv --idle 0.1",
    "sheet": "compare gyro.csv --datasheet adis16470", "limits": "analyze gyro.csv --limits l.toml",
}  # fmt: skip


def run(line):
    result = CliRunner().invoke(main, line.split())
    assert result.exit_code in (0, 4), (line, result.output)
    return re.sub(r"\s+", " ", result.stdout)


@pytest.mark.slow("every verb that shows a coefficient")
def test_every_verb_shows_the_same_digits(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "l.toml").write_text(LIMITS)
    for seed, name in enumerate(("gyro", "other")):
        rng = np.random.default_rng(seed)
        record = al.simulate(al.Model("N 0.1 deg/sqrt(h), B 2 deg/h"), 6000, 10.0, rng=rng, unit="deg/h", name="gx")
        al.write(record, tmp_path / f"{name}.csv")
    run("batch . --out results --workers 1")
    channel = al.analyze("gyro.csv")["gx"]
    N, least = channel.fit["N"].rounded("deg/sqrt(h)"), channel.readings.lowest()
    shown = {name: run(line) for name, line in VERBS.items()}
    assert [name for name, text in shown.items() if not re.search(rf"(?<![\d.]){N.value}(?![\d.])", text)] == []
    assert [name for name, text in shown.items() if least.words() not in text and name != "details"] == []
    assert f"{least.value} {least.low} .. {least.high} °/h" in shown["details"]
    assert f"{N.value} {N.low} .. {N.high} °/√h" in shown["details"]
    run("analyze gyro.csv --json a.json --report a.html")
    page = (tmp_path / "a.html").read_text("utf-8").replace("\N{NO-BREAK SPACE}", " ")
    assert (least.pretty() in page, f">{N.value} ± " in page) == (True, True)
    (stored,) = json.loads((tmp_path / "a.json").read_text("utf-8"))["channels"]
    rows = {row["quantity"]: row for row in stored["data_sheet"] if row["unit"] in ("deg/h", "deg/sqrt(h)")}
    for title, number in (("in-run bias stability", least), ("angle random walk N", N)):
        assert digits(*(rows[title][key] for key in ("value", "low", "high"))) == number
