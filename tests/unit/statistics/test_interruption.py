"""Ctrl-C is answered while a compiled loop goes on; benchmarks/kills.py measures it for every verb."""

import os
import signal
import sys
import threading

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.parallel.processes import spread
from allanite.statistics import estimator


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
@rows("threads", [1, 2])
def test_an_interruption_does_not_wait_for_what_other_threads_compute(threads):
    ended, by = threading.Event(), []

    def loop(_):
        by.append(threading.current_thread())
        os.kill(os.getpid(), signal.SIGINT)
        ended.wait()

    with pytest.raises(KeyboardInterrupt):
        spread(loop, [0], threads)
    ended.set()
    assert by[0] is not threading.main_thread()


@rows("statistic, threads", [("mtotdev", 1), ("htotdev", 2), ("mtie", 1)])
def test_long_loops_run_in_other_threads(monkeypatch, statistic, threads):
    def kept_away(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(estimator, "spread", kept_away)
    al.deviation(al.Record(np.arange(200) % 7 + 0.5, rate=100.0, unit="deg/h"), statistic, noise=None)
    record = al.Record(np.random.default_rng(1).standard_normal(2_000_000), rate=100.0, unit="deg/h")
    with pytest.raises(KeyboardInterrupt):
        al.deviation(record, statistic, taus="log", noise=None, threads=threads)
