"""Work that is shared between processes: the same results, the same errors, nothing left behind."""

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from tests import all_but
from tests.rows import rows

import allanite as al
from allanite.parallel.processors import how_many, processes, shared
from allanite.reporting import page

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks only where they are safe")

N = 4000


@pytest.fixture(scope="module")
def recording():
    model = al.N(0.2, "deg/sqrt(h)") + al.B(2.0, "deg/h")
    records = [al.simulate(model, size=N, rate=50.0, rng=np.random.default_rng([5, i]), name=f"g{i}") for i in range(3)]
    return al.Recording(tuple(records))


@rows("count", [1, 2, 3, 7])
def test_results_are_in_the_order_of_the_items(count):
    assert shared(lambda x: x * x, list(range(20)), count=count) == [x * x for x in range(20)]


def test_several_processes_take_part():
    both = multiprocessing.get_context("fork").Barrier(2)

    def where(_: int) -> int:
        both.wait(60)
        return os.getpid()

    places = set(shared(where, list(range(8)), count=2))
    assert len(places) == 2
    assert os.getpid() in places


def test_what_is_known_is_not_copied():
    known = [np.arange(5.0), np.arange(3.0)]
    found = shared(lambda i: (known[i % 2], known[i % 2] + 1), list(range(6)), count=2, known=known)
    assert all(same is known[i % 2] for i, (same, _) in enumerate(found))
    assert all((new == known[i % 2] + 1).all() for i, (_, new) in enumerate(found))


def test_the_error_is_that_of_the_first_item():
    def work(i: int) -> None:
        if i in (3, 5):
            raise ValueError(f"item {i}")

    for count in (1, 2, 3):
        with pytest.raises(ValueError, match="item 3"):
            shared(work, list(range(9)), count=count)
    assert not multiprocessing.active_children()


def test_what_a_killed_process_did_not_do_is_done_here():
    here, killed = os.getpid(), multiprocessing.get_context("fork").Event()

    def work(i: int) -> int:
        if os.getpid() != here:
            killed.set()
            os.kill(os.getpid(), signal.SIGKILL)
        killed.wait(60)
        return i

    assert shared(work, list(range(6)), count=3) == list(range(6))
    assert not multiprocessing.active_children()


def test_what_cannot_be_pickled_is_done_here():
    assert [found() for found in shared(lambda i: lambda: i, list(range(4)), count=2)] == [0, 1, 2, 3]


def test_cached_results_come_back(recording):
    record = recording[0]
    curve = al.deviation(record, noise=al.identify(record).model)
    (back, _) = shared(lambda _: curve, [0, 1], count=2)
    np.testing.assert_array_equal(back.interval(0.9), curve.interval(0.9))
    assert pickle.loads(pickle.dumps(curve)).law is not None


def test_work_within_work_is_not_shared_again():
    with processes(3):
        assert (how_many(2), shared(lambda _: how_many(5), [0, 1, 2, 3], count=2)) == (2, [1, 1, 1, 1])
    assert how_many(5) == 1


@pytest.mark.all_processors
def test_as_many_processes_as_the_samples_allow():
    with processes(None):
        assert (how_many(100, samples=2**30), how_many(100)) == (1, len(os.sched_getaffinity(0)))
    with processes(2):
        assert how_many(100, samples=2**30) == 2


@pytest.mark.slow("several processes")
def test_a_study_and_its_page_are_the_same_bit_for_bit_and_keep_the_records(recording):
    """The last of the channels is refused."""
    mixed = al.Recording((*recording.records, al.Record(np.zeros(N), rate=50.0, unit="deg/h", name="dead")))
    results = []
    for count in (1, 2, 3):
        with processes(count):
            study = al.analyze(mixed)
            results.append((repr(study.to_dict()), page(study)))
        assert all(channel.record is record for channel, record in zip(study.channels, mixed, strict=True))
    assert results[0] == results[1] == results[2]
    assert study["dead"].refusal


INTERRUPTED = """
import os, signal, time
from allanite.parallel.processors import shared

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs begin with it ignored

def work(i):
    os.write(1, b"%d\\n" % os.getpid())
    parent = os.getppid()
    while os.getppid() == parent:
        time.sleep(0.01)

shared(work, list(range(8)), count=3)
"""


@rows("by", all_but([signal.SIGINT, signal.SIGKILL], [signal.SIGKILL]))
def test_no_process_is_left_behind(by):
    with subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True) as process:  # fmt: skip
        assert process.stdout is not None
        workers = {int(process.stdout.readline()) for _ in range(3)}
        process.send_signal(by)
        assert process.wait(timeout=120) != 0
    while any(map(running, workers)):
        time.sleep(0.01)


def running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
