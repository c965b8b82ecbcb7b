"""Every deviation of the Stable32 1.53 and 1.60 tables that are published with allantools, to the five printed digits.

The tables and the records they were made of (Stable32's PHASE.DAT; a caesium clock against a maser; simulated flicker
of 42 s sampling) are not part of this project: the tests find them in ALLANITE_REFERENCE, or beside the project.
"""

import re
from functools import cache

import numpy as np
import pytest
from tests.anchors.values import WHO, Data, affordable, disagreements, value

ALLAN = ["adev", "oadev", "mdev", "tdev", "hdev", "ohdev"]
TOTAL = ["totdev", "mtotdev", "ttotdev", "htotdev"]

TABLES = [
    # record, file, statistic
    *(("PHASE.DAT", f"phasedat/phase_dat_{name}.txt", name) for name in [*ALLAN, "tierms", "mtie"]),
    *(("PHASE.DAT", f"phasedat/phase_dat_{name}_octave.txt", name) for name in ALLAN + TOTAL),
    ("PHASE.DAT", "phasedat/phase_dat_mtotdev_octave_alpha0.txt", "mtotdev"),
    ("PHASE.DAT", "phasedat/phase_dat_htotdev_octave_nobias.txt", "htotdev"),
    ("PHASE.DAT", "phasedat/phase_dat_theo1_alpha0_decade.txt", "theo1"),
    *(("5071A", f"Cs5071A/{name}_decade.txt", name) for name in [*ALLAN, "totdev", "tierms", "mtie"]),
    ("5071A", "Cs5071A/mtie_fast.txt", "mtie"),
    *(("pink", f"pink_frequency/{name}.txt", name) for name in ALLAN),
    ("pink", "pink_frequency/totdev_alpha0.txt", "totdev"),
    ("pink", "pink_frequency/s32_oadev_octave.txt", "oadev"),
]

BIAS_REMOVED = "phasedat/phase_dat_htotdev_octave.txt"
"""The one table with a bias removed: its variances are raw / 0.995 where white noise was identified and m > 1."""


@cache
def record_of(folder, name):
    if name == "PHASE.DAT":
        return Data(1.0, np.loadtxt(folder / "phasedat/PHASE.DAT"))
    if name == "5071A":
        return Data(1.0, np.loadtxt(folder / "Cs5071A/5071A_phase.txt.gz"))
    return Data.of_rate(np.loadtxt(folder / "pink_frequency/pink_frequency.txt.gz"), 42.0)


def rows_of(path):
    """(m, noise identified or None, printed value) of every row, those commented out too."""
    rows = []
    for line in path.read_text(encoding="latin-1").splitlines():
        cells = line.lstrip("# ").split()
        if not all(re.fullmatch(r"[-+.\de]+", cell) for cell in cells):
            continue
        if len(cells) == 7:  # m, tau, terms, noise, low, deviation, high
            rows.append((int(cells[0]), int(cells[3]), cells[5]))
        elif len(cells) == 4:  # m, tau, terms, value
            rows.append((int(cells[0]), None, cells[3]))
    return rows


@pytest.mark.parametrize("who", WHO)
@pytest.mark.parametrize(("record", "file", "statistic"), TABLES, ids=str)
def test_every_printed_digit(reference, who, record, file, statistic):
    data = record_of(reference, record)
    rows = [row for row in rows_of(reference / file) if affordable(who, statistic, data, row[0])]
    assert len(rows) >= 5
    found = value(who, statistic, data, [m for m, _, _ in rows])
    bias = [0.995 if file == BIAS_REMOVED and m > 1 and noise == 0 else 1 for m, noise, _ in rows]
    assert not disagreements(found / np.sqrt(bias), [printed for _, _, printed in rows])


def test_every_table_is_asked_for(reference):
    """No table without a test, no row that was not read: what the files hold is counted once."""
    folders = ("phasedat", "Cs5071A", "pink_frequency")
    files = {str(path.relative_to(reference)) for name in folders for path in (reference / name).glob("*.txt")}
    assert files == {file for _, file, _ in TABLES}
    assert sum(len(rows_of(reference / file)) for file in files) == 2673
