"""A quantity of a channel is the same, to the last printed digit, in every verb and form.

``python -m pytest -s tests/stories/test_one_number.py`` prints the grid: quantities by verbs and forms.
"""

import csv
import json
import re
from pathlib import Path

import pytest
from tests import verbs

import allanite as al
from allanite.core.digits import Digits, digits
from allanite.core.fit import chance
from allanite.reporting.words import signed
from allanite.web.faces import described

LIMITS = '[limits]\nN = { max = "0.001 deg/sqrt(h)" }\nminimum = { max = "0.001 deg/h" }\n'
SIZES = {"gx": "N 0.1 deg/sqrt(h), B 4 deg/h, R 100 deg/h^2", "gy": "N 0.1 deg/sqrt(h), K 60 deg/h/sqrt(h), Q 2 arcsec"}
LEAST, P = "in-run", "p"
WHOLE = (*"NBKRQ", "GM", LEAST, P)
VERBS = {
    "analyze": ("analyze gyro.csv", WHOLE), "details": ("analyze gyro.csv --details", WHOLE),
    "several": ("analyze gyro.csv other.csv", ("N", LEAST)), "lot": ("lot results", ("N", LEAST)),
    "watch": ("watch gyro.csv --idle 0.1", WHOLE), "limits": ("analyze gyro.csv --limits l.toml", WHOLE),
    "sheet": ("compare gyro.csv --datasheet adis16470", ("N", LEAST)), "plan": ("plan gyro.csv", WHOLE[:-2]),
    "drift": ("drift gyro.csv --require '1 deg in 10 min' --channels gx", ("N", "B")),
    "export": ("export gyro.csv", WHOLE[:-1]),
}  # fmt: skip
"""Commands, and the quantities that each shows."""


def run(line):
    return re.sub(r"\s+", " ", verbs.run(line, 4).stdout)


def holds(text, number):
    return re.search(rf"(?<![\d.]){re.escape(number)}(?![\d.]*\d)", text) is not None


def text_of(html):
    return re.sub(r"\s+", " ", re.sub("<[^>]*>", " ", html))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The folder of two recordings and of their stored results, and the study of the first."""
    folder = tmp_path_factory.mktemp("one")
    (folder / "l.toml").write_text(LIMITS)
    for seed, name in enumerate(("gyro", "other")):
        parts = [al.simulate(al.Model(text), 6000, 10.0, rng=seed, unit="deg/h", name=n) for n, text in SIZES.items()]
        al.write(al.Recording(tuple(parts)), folder / f"{name}.csv")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        run("batch . --out results --workers 1")
        yield al.analyze("gyro.csv")


def shown(study):
    """What analyze prints of each quantity of each channel: a value with its interval, or an upper limit."""
    for channel in study:
        for e in channel.fit:
            number = e.rounded(e.sheet_unit, signed=signed(e)) if e.valued else e.rounded_limit(e.sheet_unit)
            if number is not None:
                yield channel.record.name, e.symbol, number, e.valued
        yield channel.record.name, LEAST, channel.readings.lowest(), True
        p = chance(channel.noise.residuals.goodness.p).rpartition(" ")[2]
        yield channel.record.name, P, Digits(p, "", ""), True


@pytest.mark.slow("every verb that shows a coefficient")
def test_every_verb_shows_the_same_digits(study):
    numbers, grid = list(shown(study)), []
    assert {symbol for _, symbol, *_ in numbers} >= {"N", "B", "K", "Q", LEAST, P}
    for verb, (line, symbols) in VERBS.items():
        text = run(line)
        only = line.partition("--channels ")[2] or "gx,gy"
        own = [row for row in numbers if row[1] in symbols and row[0] in only.split(",")]
        kept = {row[:2]: holds(text, row[2].plain()[0]) for row in own if row[3] or verb in ("analyze", "details")}
        grid += [f"{verb:8} {' '.join(f'{channel}.{symbol}' for channel, symbol in kept)}"]
        assert [key for key, same in kept.items() if not same] == [], (verb, text)
    print("\n".join(grid))  # noqa: T201 - for those who ask for it with -s


@pytest.mark.slow("every form of a result")
def test_every_form_has_the_same_digits(study):
    run("analyze gyro.csv --json a.json --report a.html --coefficients a.csv")
    data = json.loads(Path("a.json").read_text("utf-8"))
    rows = list(csv.DictReader(Path("a.csv").read_text("utf-8").splitlines()))
    texts = {"report": text_of(Path("a.html").read_text("utf-8")), "page": text_of(str(described(study, "en")))}
    terms = {(c["name"], t["symbol"]): t["shown"] for c in data["channels"] for t in c["fit"]["terms"]}
    for channel, symbol, number, valued in shown(study):
        if symbol == P:
            continue
        for name, text in texts.items():
            assert holds(text, number.pretty().split(" (")[0]), (name, channel, symbol, number)
        if not valued:
            continue
        term = "minimum" if symbol == LEAST else symbol
        (row,) = [row for row in rows if (row["channel"], row["term"]) == (channel, term)]
        assert digits(*(float(row[key]) for key in ("value", "low", "high"))).plain() == number.plain()
        if symbol != LEAST:
            assert digits(*list(terms[channel, symbol].values())[:3]).plain() == number.plain()
