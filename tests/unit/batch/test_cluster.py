"""Dask: the same bytes as from one process, on workers of their own."""

import json
import os
import subprocess
import sys
import time
from queue import SimpleQueue

import pytest
from tests.commands import run
from tests.rows import refused
from tests.unit.batch.tasks import contents, deadly, doubled, waiting, with_bad

import allanite as al
from allanite.batch.executor import Dask
from allanite.batch.job import run_batch

distributed = pytest.importorskip("distributed")

pytestmark = pytest.mark.slow("a scheduler and its workers")

STARTING = 600  # seconds in which a worker starts


@pytest.fixture(scope="module")
def address():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


def test_dask_gives_the_same_bytes(tmp_path, address):
    units = with_bad(tmp_path / "units", [0.1, 0.2, 0.3])
    assert len(run_batch(units, tmp_path / "one").failed) == 1
    run("batch", units, "--out", tmp_path / "other", "--scheduler", address, code=5)
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


def test_an_error_and_a_lost_worker_belong_to_their_item(address, tmp_path):
    found = {done.item["x"]: done for done in Dask(address).run(doubled, [{"x": x} for x in (1, 3)])}
    assert (found[1].result, found[3].error) == ({"y": 2}, "internal error (RuntimeError: three)")
    (done,) = Dask(address).run(deadly, [{"x": "once", "mark": str(tmp_path / "mark")}])
    assert done.result


def test_a_scheduler_that_does_not_answer_is_named(monkeypatch):
    monkeypatch.setattr("allanite.batch.executor.PATIENCE", 1)
    said = r"'tcp://127.0.0.1:9' does not answer .*; start one with 'dask scheduler'"
    refused(al.UsageError, said, lambda: list(Dask("tcp://127.0.0.1:9").run(doubled, [{"x": 1}])))


@pytest.fixture
def start(monkeypatch):
    """Starts ``dask scheduler`` or ``dask worker``, in an environment of its own."""
    monkeypatch.setattr("allanite.batch.executor.PATIENCE", 120)
    started = []

    def starting(*arguments, path=()):
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([*map(str, path), *filter(None, sys.path)])}
        words = [sys.executable, "-m", "dask", *arguments]
        started.append(subprocess.Popen(words, env=environment, stderr=subprocess.DEVNULL))
        return started[-1]

    yield starting
    for process in reversed(started):
        process.terminate()
        process.wait()


class Soon(SimpleQueue):
    """A queue that is asked for a second only."""

    def get(self, timeout):
        return super().get(timeout=1)


@pytest.fixture
def scheduler(start, tmp_path):
    """The process of a scheduler without workers, its address, and what starts a worker and waits until it is there."""
    told = tmp_path / "scheduler.json"
    process = start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(told))
    while not told.exists() or not told.read_text():
        time.sleep(0.01)
    at = json.loads(told.read_text())["address"]

    def worker(*arguments, path=()):
        start("worker", at, "--nthreads", "1", "--no-dashboard", *arguments, path=path)
        with distributed.Client(at, timeout=120) as client:
            client.wait_for_workers(1, timeout=STARTING)

    return process, at, worker


@pytest.mark.filterwarnings("ignore:Mismatched")
@pytest.mark.parametrize("name", ["allanite", "numpy"])
def test_workers_of_other_versions_are_refused_before_any_work(scheduler, tmp_path, name):
    _, at, worker = scheduler
    (tmp_path / f"{name}-0.0.7.dist-info").mkdir()
    (tmp_path / f"{name}-0.0.7.dist-info" / "METADATA").write_text(f"Name: {name}\nVersion: 0.0.7\n")
    worker(path=[tmp_path])
    said = rf"tcp://\S+ has {name} 0.0.7 instead of \d\S+; install the same versions everywhere"
    mark = tmp_path / "mark"
    refused(al.UsageError, said, lambda: list(Dask(at).run(deadly, [{"x": "once", "mark": str(mark)}])))
    assert not mark.exists()


def test_a_scheduler_whose_last_worker_died_is_named(scheduler, tmp_path, monkeypatch):
    _, at, worker = scheduler
    wait = distributed.Client.wait_for_workers

    def soon(client, count, timeout):
        return wait(client, count, timeout if timeout == STARTING else 1)

    monkeypatch.setattr(distributed.Client, "wait_for_workers", soon)
    monkeypatch.setattr("allanite.batch.executor.SimpleQueue", Soon)
    said = "has no worker; start some with 'dask worker tcp://"
    refused(al.UsageError, said, lambda: list(Dask(at).run(doubled, [{"x": 1}])))
    worker("--no-nanny")
    item, said = {"x": "once", "mark": str(tmp_path / "mark")}, "has no worker; .* what is stored is not done again"
    refused(al.UsageError, said, lambda: list(Dask(at).run(deadly, [item])))
    assert (tmp_path / "mark").exists()


def test_a_scheduler_that_ends_is_named(scheduler, tmp_path):
    process, at, worker = scheduler
    worker()
    done = Dask(at).run(waiting, [{"x": 0}, {"x": 3600}])
    assert next(done).result
    process.kill()
    refused(al.UsageError, "ended before the work was done; start it again", lambda: next(done))
