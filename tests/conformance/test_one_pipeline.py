"""One way for samples: a whole record, the same one in parts, and watched give the same, or the same refusal."""

import os
from contextlib import closing
from operator import attrgetter

import numpy as np
import pytest
from tests import ALL
from tests.rows import rows

import allanite as al
from allanite.core.choices import choices_of, named
from allanite.study.analysis import examine
from allanite.study.keeper import needing_all
from allanite.study.recipe import Recipe
from allanite.study.watching import Watch, WatchSettings

pytestmark = pytest.mark.nightly("every file and choice in three ways")

SIZE = 6000
RATE = 50.0


def noise(columns=2, seed=1, size=SIZE):
    return np.random.default_rng(seed).normal(size=(size, columns))


def text(values, header="", form="%.5f", between=","):
    rows = "\n".join(between.join(form % value if np.isfinite(value) else "nan" for value in row) for row in values)
    return (header + "\n" if header else "") + rows + "\n"


def stamped(values, step=1 / RATE, cut=None):
    t = np.arange(len(values)) * step
    if cut is not None:
        t[cut:] += 1.0
    return np.column_stack((t, values))


def spoiled(places, change):
    """Noise, changed in one place."""
    values = noise()
    values[places] = change(values[places])
    return text(values, "gx [deg/h],gy [deg/h]"), {"rate": RATE}


FILES = {
    "plain": (text(noise()), {"rate": RATE, "unit": "deg/h"}),
    "named": (text(noise(), "gx [deg/h],gy [deg/h]"), {"rate": RATE}),
    "semicolons": (text(noise(), "gx [deg/h];gy [deg/h]", between=";"), {"rate": RATE}),
    "blanks": (text(noise(3), between=" "), {"rate": RATE, "unit": "deg/s"}),
    "stamped": (text(stamped(noise(1)), "t [s],gx [deg/h]"), {}),
    "gap": (text(stamped(noise(), cut=2500), "t [s],gx [deg/h],ax [mg]"), {}),
    "angle": (text(np.cumsum(noise(), axis=0), "x [arcsec],y [arcsec]"), {"rate": RATE, "kind": "angle"}),
    "counts": (text(np.round(30 * noise()), "x [arcsec],y [arcsec]", "%d"),
               {"rate": RATE, "kind": "count", "scale": 0.1}),
    "increments": (text(noise(), "x [arcsec],y [arcsec]"), {"rate": RATE, "kind": "increment"}),
    "outliers": spoiled(([700, 4000], 0), lambda y: y + 60.0),
    "motion": spoiled(np.s_[3000:3400, 1], lambda y: y * 400.0),
    "stuck": spoiled(np.s_[2000:2100, 0], lambda y: y[0]),
    "constant": spoiled(np.s_[:, 1], lambda y: 2.0), "missing": spoiled(np.s_[1000:1100, 0], lambda y: np.nan),
    "rounded": spoiled(np.s_[:], np.round),
    "short": (text(noise(size=300), "gx [deg/h],gy [deg/h]"), {"rate": RATE}),
    "unknown": (text(noise()), {"rate": RATE}),
}  # fmt: skip

CHOICES = {
    "rate": 49.0, "unit": "deg/s", "kind": "rate", "scale": 2.0, "channels": ("2",), "time": "none", "dtype": "i2",
    "columns": 2, "offset": 8, "sincos": ("gx", "gx"), "average": 0.1, "exclude": "20..30,50..51", "start": 20.0,
    "until": 100.0, "quiet_window": 50.0, "outliers": "mark", "motion": "mark", "memory": "1TB", "statistic": "ohdev",
    "taus": "octave", "terms": "N", "method": "gls", "ranges": {"N": (0.1, 1.0)}, "band": (0.5, 20.0),
    "mask": "3..4,10..11", "level": 0.9, "device": "mems", "to": ("deg/s",), "about": ("serial=1",),
}  # fmt: skip
"""A value of each choice."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pipeline")


def written(name, folder):
    path = folder / f"{name}.csv"
    if not path.exists():
        path.write_text(FILES[name][0])
    return path


def outcome(job):
    """A study, or the words with which it is refused."""
    try:
        return job()
    except (al.DataError, al.UsageError) as error:
        return f"{type(error).__name__}: {error}"


def watched(path, recipe):
    with closing(Watch(str(path), recipe, WatchSettings())) as watch:
        watch.stopped = lambda: watch.spool is not None and watch.spool.came >= os.path.getsize(path)
        list(watch.events())
        return watch.study()


def compare(path, options):
    """Watch and parts against the whole."""
    whole = outcome(lambda: al.analyze(path, Recipe(**options)))
    mine = outcome(lambda: watched(path, Recipe(**({"motion": "refuse"} | options))))
    if isinstance(whole, str):
        assert mine == whole
    else:
        assert mine.to_dict()["channels"] == whole.to_dict()["channels"]
        assert mine.findings == whole.findings
        assert mine.provenance == whole.provenance
    in_parts(path, options, whole)


def in_parts(path, options, whole=None, job=al.analyze):
    """A job that reads in parts against the whole."""
    recipe = Recipe(**(options | {"memory": "1kB"}))
    whole = outcome(lambda: job(path, Recipe(**options))) if whole is None else whole
    parts = outcome(lambda: job(path, recipe))
    if parts == whole or (isinstance(parts, str) and any(f"no {row.name}" in parts for row, _ in needing_all(recipe))):
        return  # refused in the same words, or by the row of the choice
    assert not isinstance(parts, str), parts
    assert not isinstance(whole, str), whole
    assert [c.record.name for c in parts] == [c.record.name for c in whole]
    assert parts.findings == whole.findings
    for one, other in zip(parts, whole, strict=True):
        for name in ("quality", "refusal", "record.rate", "record.size"):
            assert attrgetter(name)(one) == attrgetter(name)(other), name
        if other.fit is not None:
            same_noise(one.fit, other.fit)


def same_noise(one, other):
    """The terms that both identify, within the limits of both; what both measure directly, to the digits shown."""
    found = {estimate.symbol: estimate for estimate in one}
    for estimate in (each for each in other if each.symbol in found):
        mine = found[estimate.symbol]
        assert not (mine.claimed and estimate.status == "not valid"), estimate.symbol
        if estimate.status == mine.status == "identified":
            (low, high), (least, most) = estimate.interval(), mine.interval()
            assert low <= mine.value <= high
            assert least <= estimate.value <= most


FEW = ("named", "gap", "angle", "counts", "outliers", "motion")


@rows("name", FILES if ALL else FEW)
def test_a_file_is_the_same_in_all_ways(name, folder):
    compare(written(name, folder), FILES[name][1])


@rows("choice", CHOICES if ALL else [*named(Recipe, "selecting"), "mask", "method"])
def test_a_choice_is_the_same_in_all_ways(choice, folder):
    compare(written("stamped", folder), FILES["stamped"][1] | {choice: CHOICES[choice]})


@rows("name", FILES)
def test_every_choice_of_every_file_is_inspected_alike(name, folder):
    """The grid of all choices and files, without the identification, which takes most of the time."""
    for choice in choices_of(Recipe):
        in_parts(written(name, folder), FILES[name][1] | {choice: CHOICES[choice]}, job=examine)
