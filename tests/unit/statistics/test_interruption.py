"""Ctrl-C is answered at once; every verb and every statistic are interrupted by benchmarks/signals.py."""

import signal
import subprocess
import sys
import time

import pytest
from tests.pace import pace

JOB = """
import sys, time
import numpy as np
import allanite as al
small = al.Record(np.random.default_rng(1).standard_normal(4000), rate=100.0, unit="deg/h")
record = al.Record(np.random.default_rng(1).standard_normal({size}), rate=100.0, unit="deg/h")
def job(record):
    {job}
job(small)
print("now", flush=True)
try:
    job(record)
except KeyboardInterrupt:
    print(time.monotonic(), flush=True)
"""
JOBS = {
    "mtotdev": ("al.deviation(record, 'mtotdev', noise=None)", 5_000_000),
    "htotdev by two threads": ("al.deviation(record, 'htotdev', noise=None, threads=2)", 5_000_000),
    "mtie": ("al.deviation(record, 'mtie', taus='log', noise=None)", 5_000_000),
}


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
@pytest.mark.parametrize("name", JOBS)
@pytest.mark.slow("interrupted processes")
def test_an_interruption_is_answered_within_a_second(name):
    job, size = JOBS[name]
    running = subprocess.Popen(
        [sys.executable, "-c", JOB.format(job=job, size=size)], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert running.stdout.readline() == b"now\n"
    time.sleep(0.4)
    if running.poll() is None:
        start = time.monotonic()
        running.send_signal(signal.SIGINT)
        answered, words = running.communicate(timeout=120)
        assert not words
        assert not answered or float(answered) - start < pace()
