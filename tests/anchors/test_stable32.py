"""Every deviation that Stable32 1.53 and 1.60 printed for three records, to the five printed digits.

Its sample record PHASE.DAT is made here by the published rule. The records of a caesium clock against a maser and of
simulated flicker, 42 s apart, are not part of this project: they are asked for nightly, where ALLANITE_REFERENCE or a
folder beside the project has them.
"""

import re

import numpy as np
import pytest
from tests.anchors.values import WHO, Data, affordable, disagreements, lcg, printed, value
from tests.reference.terms import phase
from tests.rows import rows

RATE = lcg() - lcg().mean()
PHASE = Data(1.0, phase(RATE, 1.0))
TABLES = {name: values for (name,), values in printed("stable32.txt")}
SLOW_CLOCK = 42.0  # seconds between samples, which a table for 1 s is scaled to


def biases(name, values):
    """The one table with a bias removed: its variances are raw / 0.995 where white noise was identified and m > 1."""
    return [0.995 if name == "htotdev_bias" and m > 1 and more == ["0"] else 1.0 for m, _, *more in values]


@rows("name", TABLES)
def test_every_printed_digit(name):
    statistic, values = name.partition("_")[0], TABLES[name]
    for who in WHO:
        asked = [row for row in values if affordable(who, statistic, PHASE, row[0])]
        assert len(asked) >= 5
        found = value(who, statistic, PHASE, [row[0] for row in asked]) / np.sqrt(biases(name, asked))
        assert not disagreements(found, [row[1] for row in asked]), who


@rows("name", ["adev_octave", "mdev_octave", "tdev_octave", "ohdev_octave", "totdev", "theo1", "tierms", "mtie"])
def test_the_interval_between_samples_scales_what_it_must(name):
    """Of the same phase twice as far apart in time, deviations of the rate are smaller, those of the phase the same."""
    statistic, (factors, expected) = name.partition("_")[0], list(zip(*TABLES[name], strict=True))[:2]
    scale = 1.0 if statistic in ("tdev", "tierms", "mtie") else SLOW_CLOCK
    found = value("allanite", statistic, Data(SLOW_CLOCK, PHASE.x), factors) * scale
    assert not disagreements(found, expected)


def test_every_published_value_is_read():
    assert (sum(len(values) for values in TABLES.values()), set(WHO)) == (1063, {"referee", "allanite"})


ALLAN = ["adev", "oadev", "mdev", "tdev", "hdev", "ohdev"]
ELSEWHERE = [
    # folder, record, seconds between samples, file, statistic
    *(("Cs5071A", f"{name}_decade.txt", name) for name in [*ALLAN, "totdev", "tierms", "mtie"]),
    ("Cs5071A", "mtie_fast.txt", "mtie"),
    *(("pink_frequency", f"{name}.txt", name) for name in ALLAN),
    ("pink_frequency", "totdev_alpha0.txt", "totdev"),
    ("pink_frequency", "s32_oadev_octave.txt", "oadev"),
]


@pytest.fixture(scope="module")
def records(reference):
    """The records that are not part of the project."""
    clock = np.loadtxt(reference / "Cs5071A" / "5071A_phase.txt.gz")
    pink = np.loadtxt(reference / "pink_frequency" / "pink_frequency.txt.gz")
    return {"Cs5071A": Data(1.0, clock), "pink_frequency": Data.of_rate(pink, SLOW_CLOCK)}


def rows_of(path):
    """(m, printed value) of every row of a table of Stable32, those commented out too."""
    lines = (line.lstrip("# ").split() for line in path.read_text(encoding="latin-1").splitlines())
    cells = [line for line in lines if all(re.fullmatch(r"[-+.\de]+", cell) for cell in line)]
    return [(int(line[0]), line[{7: 5, 4: 3}[len(line)]]) for line in cells if len(line) in (4, 7)]


@pytest.mark.nightly("records that are not part of the project, half a million samples")
@rows("folder, file, statistic", ELSEWHERE)
def test_every_printed_digit_of_records_elsewhere(reference, records, folder, file, statistic):
    for who in WHO:
        asked = [
            row for row in rows_of(reference / folder / file) if affordable(who, statistic, records[folder], row[0])
        ]
        assert len(asked) >= 5
        found = value(who, statistic, records[folder], [m for m, _ in asked])
        assert not disagreements(found, [number for _, number in asked]), who
