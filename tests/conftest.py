"""Where real recordings and published tables are, for the tests that use them."""

import gc
import os
import signal
from pathlib import Path

import hypothesis
import pytest

from tests import ROOT, examples

# a machine with other work to do is no failure
hypothesis.settings.register_profile("unhurried", deadline=None, max_examples=examples(100))
hypothesis.settings.load_profile("unhurried")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background; tests end programs by Ctrl-C
    signal.signal(signal.SIGINT, signal.default_int_handler)

collect_ignore = ["plugin"]
"""A package of its own, whose tests are run where it is installed: `stories/test_plugins.py`."""

WORKER = os.environ.get("PYTEST_XDIST_WORKER", "")[2:]

PROCESSORS = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []

LONG = pytest.mark.slow("takes more than half a second")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave to `make test-all` what took more than half a second when it was measured: see tools/sets.py."""
    long = set((ROOT / "tests" / "long.txt").read_text("utf-8").splitlines())
    for item in items:
        if item.nodeid.partition("[")[0] in long and not item.get_closest_marker("slow"):
            item.add_marker(LONG)


def pytest_runtest_setup(item):
    """Give each worker a processor of its own, so that jobs fork no helpers that wait for each other.

    Not so where a test itself says that it is slow: it may be about several processes.
    """
    if WORKER and PROCESSORS:
        alone = item.get_closest_marker("slow") in (None, LONG.mark)
        os.sched_setaffinity(0, {PROCESSORS[int(WORKER) % len(PROCESSORS)]} if alone else PROCESSORS)


def pytest_collection_finish():
    """Leave thousands of collected tests to themselves: collecting garbage would go through them again and again."""
    gc.collect()
    gc.freeze()


def pytest_unconfigure():
    """Let libraries find at the end what they have made."""
    gc.unfreeze()


BESIDE = Path(__file__).resolve().parents[2] / "shared"


def _folder(variable, name, needed):
    folder = Path(os.environ.get(variable, BESIDE / name))
    if not (folder / needed).is_file():
        pytest.skip(f"no {name} in {folder}; set {variable} to the folder that holds {needed}")
    return folder


@pytest.fixture
def details(monkeypatch):
    """Commands print all numbers, not the first screen."""
    monkeypatch.setenv("ALLANITE_DETAILS", "1")


@pytest.fixture(scope="module", autouse=True)
def _details_of_rooms(request):
    """The tests of rooms read all numbers; stories and recordings read what a user does."""
    with pytest.MonkeyPatch.context() as patch:
        rooms = ("unit", "conformance", "recordings")
        if request.path.relative_to(ROOT / "tests").parts[0] in rooms and request.path.stem != "test_first_screen":
            patch.setenv("ALLANITE_DETAILS", "1")
        yield


@pytest.fixture(scope="session")
def recordings():
    """Folder of real recordings: ALLANITE_RECORDINGS, or beside the project."""
    return _folder("ALLANITE_RECORDINGS", "recordings", "psins_lasergyro.imu")


@pytest.fixture(scope="session")
def reference():
    """Folder of published reference values: ALLANITE_REFERENCE, or beside the project."""
    return _folder("ALLANITE_REFERENCE", "reference", "INDEX.md")
