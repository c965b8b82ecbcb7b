"""Where real recordings and published tables are, for the tests that use them, and what all tests share."""

import gc
import math
import os
import signal
from pathlib import Path

import hypothesis
import pytest

from allanite.parallel import processors
from tests import ROOT, examples

# a machine with other work to do is no failure
hypothesis.settings.register_profile("unhurried", deadline=None, max_examples=examples(100))
hypothesis.settings.load_profile("unhurried")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background; tests end programs by Ctrl-C
    signal.signal(signal.SIGINT, signal.default_int_handler)

collect_ignore = ["plugin"]
"""A package of its own, whose tests are run where it is installed: `stories/test_plugins.py`."""

NEEDED = ("Chromium", "Chinese characters") if os.environ.get("ALLANITE_CI") else ()
"""What continuous integration installs: a test that is skipped for want of it has failed."""

os.environ["PYTHONWARNINGS"] = "error::RuntimeWarning"
"""NumPy's are errors in the processes that tests start, too."""

COUNTED = processors.processors


def pytest_runtest_setup(item):
    """Let jobs work in one process each, of which as many run as there are processors."""
    processors.processors = COUNTED if item.get_closest_marker("all_processors") else lambda: 1


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport():
    """Take a skip for a failure where what is missing should be there; tell of a missing folder in one line."""
    report = yield
    if report.skipped and isinstance(report.longrepr, tuple):
        reason = report.longrepr[2]
        if any(word in reason for word in NEEDED):
            report.outcome, report.longrepr = "failed", f"ALLANITE_CI is set, but: {reason}"
        elif "set ALLANITE_" in reason:
            report.longrepr = (__file__, None, reason)
    return report


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


@pytest.fixture
def refusals(monkeypatch):
    """The errors with which commands of this process end, in order: their type and `code`."""
    from allanite.cli import front

    errors, usual = [], front._failure
    monkeypatch.setattr(front, "_failure", lambda error, ctx: errors.append(error) or usual(error, ctx))
    return errors


@pytest.fixture
def to_the_end(monkeypatch):
    """A file that is watched ends where it does, not when nothing has come for some time."""
    from allanite.readers.live import arrivals
    from allanite.study import watching

    monkeypatch.setattr(watching, "arrivals", lambda feed, _, __, stopped: arrivals(feed, math.inf, 1e-9, stopped))
