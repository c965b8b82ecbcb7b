"""One filter for the channels of one kind: where the summed score asks for it, for whom, and what follows."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.rows import paired, rows
from tests.unit.identification.records import covers

import allanite as al
import judge
from allanite.identification.front import finished, started
from allanite.identification.search.pooling import bases, in_common, together

pytestmark = pytest.mark.slow("searches of several channels")

RATE, N = 100.0, 0.003
SIZE = 2**13
FILTERS = {
    "rc": judge.rc(0.3), "butterworth": judge.butterworth(0.25), "average": judge.average(2), "none": ([1.0], [1.0]),
}  # fmt: skip
CUTOFF = {"rc": 30.0, "butterworth": 25.0, "average": 25.0}


def channel(kind, seed, unit="deg/s"):
    y = judge.sensor(SIZE + 1000, RATE, np.random.default_rng(seed), N=N, B=N / 5)
    return al.Record(judge.behind(y, FILTERS[kind])[1000:], RATE, unit, name=f"{kind} {seed}")


@cache
def begun(kind, seed, unit="deg/s"):
    return started(channel(kind, seed, unit))


def fits(*channels):
    return [fit() for fit in finished([begun(*each) for each in channels])]


def filters(found):
    return [None if fit.scope.filter is None else (fit.scope.filter.row, fit.scope.filter.cutoff) for fit in found]


@rows("kind, seed", paired(("rc", "butterworth", "average"), (1, 11)))
def test_channels_behind_one_filter_say_the_same_of_it(kind, seed):
    channels = [(kind, seed + i) for i in range(3)]
    alone, found = [begun(*each).fit() for each in channels], fits(*channels)
    assert len(set(filters(alone))) > 1
    assert len(set(filters(found))) == 1
    low, high = found[0].scope.filter.low, found[0].scope.filter.high
    widths = [fit.scope.filter.high - fit.scope.filter.low for fit in alone if fit.scope.filter]
    assert high - low < max(widths)
    assert low * 0.98 < CUTOFF[kind] < high * 1.02
    for fit in found:
        assert covers(fit, al.N(N, "deg/sqrt(s)"), 0.99)
        assert all(name in str(fit.notes[-1]) for name in (f"{kind} {seed + i}" for i in range(3)))


def test_one_that_is_unlike_the_others_is_left_out():
    found = fits(("butterworth", 1), ("butterworth", 2), ("none", 3))
    assert (found[0].scope.filter.cutoff, found[2].scope.filter) == (found[1].scope.filter.cutoff, None)
    assert not any("none 3" in str(note) for note in found[0].notes)


def test_kinds_and_choices_of_a_user_are_not_mixed():
    """Of two signals or rates, or where a user chose band, masks or terms, each channel is as alone."""
    gyro, other = begun("butterworth", 1).search, begun("butterworth", 2).search
    faster = replace(other, scale=replace(other.scale, rate=2 * RATE))
    accelerometer = begun("butterworth", 2, "g").search
    chosen = replace(other, automatic=False)
    for second in (faster, accelerometer, chosen):
        assert together([gyro, second]) == [None, None]
    assert None not in together([gyro, other])
    record = channel("none", 3)
    for choice in ({"band": "all"}, {"band": (0.0, 20.0)}, {"masks": [(10, 11)]}, {"terms": "QNB"}):
        assert not started(record, **choice).search.automatic


def test_noise_alone_has_no_filter_in_common():
    assert fits(("none", 3), ("none", 4))[0].scope.filter is None
    assert in_common([begun("none", seed).search.result for seed in (3, 4)]) == {}


def test_the_price_is_paid_once_and_information_adds():
    results = [begun("butterworth", seed).search.result for seed in (1, 2)]
    pool = in_common(results)
    first, second = (pool[j][0] for j in (0, 1))
    assert (first[:4], min(first.scores)) == (second[:4], pytest.approx(0.0, abs=0.5))
    shared = fits(("butterworth", 1), ("butterworth", 2))[0].scope.filter
    own = [np.log(f.scope.filter.high / f.scope.filter.low) for f in (begun("butterworth", s).fit() for s in (1, 2))]
    assert np.log(shared.high / shared.low) < 1.1 * (sum(w**-2 for w in own)) ** -0.5
    assert all(len(bases(result, 2)) <= 3 for result in results)


def test_what_is_begun_elsewhere_is_finished_here():
    """A process sends back what it began."""
    here = [begun("butterworth", seed) for seed in (1, 2)]
    there = pickle.loads(pickle.dumps(here))
    for one, other in zip(finished(here), finished(there), strict=True):
        assert one().to_dict() == other().to_dict()


def test_a_recording_has_one_filter_in_every_job():
    records = [channel("butterworth", seed) for seed in (1, 2)]
    recording = al.Recording(tuple(records))
    found = al.identify(recording)
    study = al.analyze(recording)
    assert len(set(filters(found.values()))) == 1
    assert filters(found.values()) == filters([c.fit for c in study.channels])
    assert "one low-pass filter is shared by" in " ".join(study.channels[0].fit.advice)
    single = al.identify(al.Recording((records[0],)))[records[0].name]
    assert filters([single]) == filters([al.identify(records[0])]) != filters(list(found.values())[:1])
