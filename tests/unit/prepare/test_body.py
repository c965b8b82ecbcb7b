"""What one channel of a body says of the others, and in which times."""

from dataclasses import replace

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.core.record import Recording
from allanite.phrases.phrase import command_line
from allanite.prepare import inspect
from allanite.prepare.stillness import moving, of_one_body, still_stretch
from allanite.prepare.view import View
from allanite.prepare.window import trim
from allanite.study.analysis import examine

RATE = 20.0
N = 20_000


def record_of(name, seed, unit="deg/s"):
    return al.Record(np.random.default_rng(seed).standard_normal(N), RATE, unit, name=name)


def moved(record, first, last, size=100.0):
    """The record with a swing between two times."""
    y = record.values.copy()
    at = slice(int(first * RATE), int(last * RATE))
    y[at] += size * np.sin(np.arange(y[at].size) / RATE)
    return replace(record, values=y)


AXES = {"gx": record_of("gx", 1), "gy": record_of("gy", 2), "ax": record_of("ax", 3, "g")}


def triad(**motion):
    """Three axes, of which some move between two times."""
    return examine(Recording(tuple(moved(one, *motion[k]) if k in motion else one for k, one in AXES.items())))


def test_one_axis_that_moves_refuses_all():
    study = triad(gy=(300, 400))
    assert all(channel.refusal for channel in study)
    assert study["gx"].refusal.startswith("the body moved: gy moves from 299.2 s")
    assert "(channels=...)" in study["ax"].refusal
    assert "the body moved" not in study["gy"].refusal
    assert "the body moved: gy" in triad(gx=(300, 305), gy=(300, 400))["gx"].refusal  # which moves less


def test_a_little_motion_warns_of_all():
    study = triad(gy=(300, 305))
    assert not any(channel.refusal for channel in study)
    assert ["body moved" in channel.quality.names for channel in study] == [True, False, True]
    assert "moving" in study["gy"].quality.names


def test_a_level_that_changes_is_told_and_refuses_none():
    louder = AXES["ax"].values * np.where(np.arange(N) < 750 * RATE, 1.0, 2.0)
    study = examine(Recording((AXES["gx"], AXES["gy"], replace(AXES["ax"], values=louder))))
    assert study["gx"].quality.names == study["gy"].quality.names == ("body level",)
    assert str(study["gx"].quality.findings[0]).startswith("on the same body, ax: the noise level changes")
    assert "body level" not in study["ax"].quality.names
    assert not any(channel.refusal for channel in study)


def test_a_thermometer_is_no_part_of_the_body():
    records = (AXES["gx"], AXES["gy"], moved(record_of("temp", 4, "degC"), 300, 400))
    found = of_one_body(records, [inspect(record) for record in records])
    assert [quality.names for quality in found[:2]] == [(), ()]
    assert found[2].refusal


def test_still_bodies_are_told_nothing():
    assert [channel.quality.names for channel in triad()] == [(), (), ()]


@rows("seed", range(5))
def test_the_stretch_that_is_offered_passes_the_test_in_every_axis(seed):
    """A body that is handled: weaker motion hides behind stronger."""
    rng = np.random.default_rng(seed)
    axes = [record_of(name, 10 + seed + i) for i, name in enumerate(("gx", "gy", "gz"))]
    for size in (4000.0, 400.0, 60.0):
        for i in range(3):
            first = float(rng.uniform(0, 900))
            axes[i] = moved(axes[i], first, first + 80, size)
    start, end = still_stretch(axes)
    assert end - start > 50
    assert all(moving(View(record)) is None for record in trim(Recording(tuple(axes)), start, end))
    study = examine(Recording(tuple(axes)))
    assert f", {end:g})" in study["gx"].refusal


def test_where_nothing_is_still_nothing_is_offered():
    y = np.random.default_rng(1).standard_normal(N)
    y *= np.where(np.arange(N) // 100 % 2, 500.0, 1.0)  # by turns, five seconds each
    study = examine(Recording((al.Record(y, RATE, "deg/s", name="gx"), AXES["gy"])))
    assert "no stretch of 10 s is static" in study["gy"].refusal


def test_times_are_those_of_the_recording_after_a_cut():
    y = np.random.default_rng(1).standard_normal(N)
    y[8000:8010] = np.nan
    y[9000] = 60.0
    part = trim(Recording((al.Record(y, RATE, "deg/s", name="gx"),)), 200.0, 600.0)[0]
    found = {finding.name: finding for finding in inspect(part).findings}
    assert found["gaps"].remedy == "the longest stretch without a gap: prepare.trim(recording, 200, 400)"
    assert found["gaps"].place == (400.0, 400.5)
    assert "the first from 400 s" in found["gaps"].what
    assert ", at 450 s, of 63.4" in found["outliers"].what
    again = trim(Recording((part,)), 100.0, 300.0)[0]
    assert (again.cut, again.history[-1]) == (300.0, "cut from 300 s to 500 s")


def test_the_still_stretch_of_a_part_is_in_times_of_the_recording():
    (part,) = trim(Recording((moved(AXES["gx"], 700, 800),)), 400.0, 1000.0)
    motion = moving(View(part))
    assert motion.what.startswith("moves from 699.2 s")
    assert motion.remedy == "the longest static stretch: prepare.trim(recording, 400, 699)"


@rows("hole", [True, False])
def test_the_stretch_that_is_offered_holds_samples_and_passes_as_it_is_typed(tmp_path, hole):
    rng = np.random.default_rng(0)
    if hole:  # 63 samples in 142 s between two motions
        t = np.concatenate((np.arange(0, 80, 0.02), 84 + 2.2 * np.arange(63), np.arange(226, 300, 0.02)))
        busy, loud, stretch = ((t >= 40) & (t < 82)) | (t >= 226), np.zeros(t.size, bool), ["--until", "40"]
    else:  # the longer stretch changes its noise level by a factor of 12
        t = np.arange(0, 600, 0.02)
        busy, loud, stretch = (t > 200) & (t < 260), (t >= 260) & (t < 420), ["--until", "200"]
    y = 0.05 * rng.normal(size=t.size) * np.where(loud, 12.0, 1.0) + 30 * busy * np.sin(t)
    path = tmp_path / "log.csv"
    path.write_text("t [s],gz [deg/s]\n" + "".join(f"{a:.2f},{b:.6f}\n" for a, b in zip(t, y, strict=True)))
    with command_line(), pytest.raises(al.DataError) as refused:
        al.analyze(path)
    assert str(refused.value).endswith(" ".join(["the longest static stretch:", *stretch]))
    channel = al.analyze(path, al.Recipe(until=float(stretch[1]))).channels[0]
    assert not channel.refusal
    assert not {"moving", "level", "gaps"} & set(channel.quality.names)


def test_a_random_walk_is_no_motion():
    model = al.Model("N 0.02 deg/sqrt(h), K 300 deg/h/sqrt(h)")
    for seed in (4, 13, 24, 35, 40, 46):
        assert "moving" not in inspect(al.simulate(model, 2**14, 10.0, rng=np.random.default_rng(seed))).names


def test_a_turn_at_a_constant_rate_is_motion():
    y = np.random.default_rng(1).standard_normal(N)
    y[N // 4 : N // 2] += 30 * np.minimum(1.0, np.arange(N // 4) / 40)  # reached within two seconds
    (found,) = inspect(al.Record(y, RATE, "deg/s", name="gz")).findings
    assert (found.name, found.fatal) == ("moving", True)
