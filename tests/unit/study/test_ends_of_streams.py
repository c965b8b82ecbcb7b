"""However a stream ends: what came is analyzed, and nothing stays behind but lines that come only once."""

import math
import os
import select
import socket
import tempfile
import threading
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.cli.tasks import WATCH, Reports
from allanite.readers import live
from allanite.readers.spool import Spool
from allanite.study import watching
from allanite.study.analysis import examine
from allanite.study.watching import Watch, WatchSettings

RECIPE = al.Recipe(rate=100.0, unit="deg/s")
FEW = 210  # rows, of which a noise coefficient can be told
_LINES = [f"{a:.5f},{b:.5f}\n".encode() for a, b in np.random.default_rng(5).normal(size=(FEW, 2)).tolist()]
ROWS = b"".join(_LINES)


class File:
    """A file that another program writes."""

    def __init__(self, folder):
        self.target = folder / "log.csv"
        self.target.touch()

    def send(self, data):
        with self.target.open("ab") as file:
            file.write(data)

    def cut(self):
        os.truncate(self.target, 0)

    def turn(self):
        self.target.rename(f"{self.target}.1")

    def leave(self):
        self.target.unlink()

    close = staticmethod(list)


class Pipe:
    """A pipe, which may have no writer."""

    def __init__(self, folder):
        self.target, self.end = folder / "pipe", -1
        os.mkfifo(self.target)

    def send(self, data):
        if self.end < 0:
            self.end = os.open(self.target, os.O_WRONLY | os.O_NONBLOCK)
        os.write(self.end, data)

    def cut(self):
        end, self.end = self.end, -1
        if end >= 0:
            os.close(end)

    turn = leave = close = cut


class Port:
    """A pair of sockets in the place of a port, which is opened again after it was unplugged."""

    def __init__(self, folder):
        self.target, self.gone = folder / "port", False
        self.target.symlink_to("/dev/null")
        self.cut()

    def open(self):
        if self.gone:
            raise al.DataError("no such port")
        mine = self.ends[1]
        mine.setblocking(False)

        def take(_):
            try:
                data = mine.recv(1 << 16)
            except BlockingIOError:
                live.time.sleep(0.2)
                return b""
            if not data:
                raise OSError("the device is gone")
            return data

        return live.Tap(take, mine.close)

    def send(self, data):
        self.ends[0].sendall(data)

    def cut(self):
        self.close()
        self.ends = socket.socketpair()

    turn = cut

    def leave(self):
        self.close()
        self.gone = True

    def close(self):
        for end in getattr(self, "ends", ()):
            end.close()


class Datagrams:
    """Datagrams of whole lines."""

    def __init__(self, _):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.bind(("127.0.0.1", 0))
            self.address = line.getsockname()
        self.target = f"udp://127.0.0.1:{self.address[1]}"
        self.line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(self, data):
        for begin in range(0, len(data), 40_000):
            self.line.sendto(data[begin : begin + 40_000], self.address)

    def close(self):
        self.line.close()

    cut = turn = leave = staticmethod(list)


SOURCES = (File, Pipe, Port, Datagrams) if hasattr(os, "mkfifo") else (File, Datagrams)

# what happens, and how many rows are analyzed at least; names are methods of the source
ENDS = {
    "nothing more": ([], 0), "a torn row": ([b"0.1,0."], 0), "half a row": ([b"0.1"], 0),
    "more fields": ([b"1,2,3\n", ROWS], FEW), "fewer fields": ([b"1\n", ROWS], FEW),
    "words": ([b"ERROR,overflow\nboot\n", ROWS], FEW), "infinite": ([b"inf,0.1\n-inf,0\n", ROWS], FEW),
    "zero bytes": ([bytes(5000) + b"\n", ROWS], FEW),
    "any bytes": ([bytes(range(256)) * 9 + b"\n", ROWS], FEW), "Latin": ([b"\xb0C,\xb5\n", ROWS], FEW),
    "a long row": ([b"1" * 39_999] * 2 + [b"\n", ROWS], FEW), "a long end": ([b"1" * 39_999] * 2, 0),
    "cut": (["cut", ROWS], FEW), "cut in a row": ([b"0.1,0", "cut", ROWS], FEW),
    "cut, then longer": (["cut", 2 * ROWS], 2 * FEW),
    "cut twice": (["cut", ROWS, "cut", ROWS], 2 * FEW), "another in its place": (["turn", 2 * ROWS], 2 * FEW),
    "another with a heading": (["turn", b"gx,gy\n", ROWS], FEW), "gone": (["leave"], 0),
    "blank lines": ([b"\n \n\r\n", ROWS], FEW), "comment": ([b"# pause\n", ROWS], FEW),
    "missing": ([b"nan,nan\n", ROWS], FEW), "other line ends": ([ROWS.replace(b"\n", b"\r\n")], FEW),
}  # fmt: skip


@pytest.fixture
def clock(monkeypatch):
    """The time goes on only where nothing comes."""
    at = SimpleNamespace(now=0.0)

    def sleep(seconds):
        at.now += seconds

    def ready(lines, *_):
        came = select.select(lines, [], [], 0.0)
        at.now += 0.0 if came[0] else 0.2
        return came

    fast = SimpleNamespace(monotonic=lambda: at.now, sleep=sleep)
    for room in (watching, live):
        monkeypatch.setattr(room, "time", fast)
    monkeypatch.setattr(live, "select", SimpleNamespace(select=ready))
    return at


class Direct:
    """A feed without a thread; where nothing comes, the next thing happens to the source."""

    def __init__(self, tap, source, steps):
        self.tap, self.source, self.steps, self.idle = tap, source, steps, 0

    def take(self, seconds):
        try:
            data = self.tap.take(0.01 if isinstance(self.source, Datagrams) else seconds)
        except BlockingIOError:
            data = b""
        if data:
            self.idle = 0
            return data
        self.idle += 1
        if isinstance(self.source, Datagrams):
            live.time.sleep(seconds)
        if self.steps and self.idle > 1:
            self.idle, step = 0, self.steps.pop(0)
            getattr(self.source, step)() if isinstance(step, str) else self.source.send(step)
        return b""

    def close(self):
        self.tap.close()
        return []


def source_of(monkeypatch, kind, folder, steps):
    """A source in a new folder, to which these things happen while it is watched."""
    folder.mkdir()
    source = kind(folder)
    monkeypatch.setattr(watching, "Feed", lambda tap: Direct(tap, source, steps))
    monkeypatch.setattr(live, "_line", lambda *_: source.open())
    return closing(source)


def ended(monkeypatch, kind, folder, steps, deliver=lambda _: None, **settings):
    """The study of what came, and what was said."""
    said = []
    monkeypatch.setattr(watching, "analyze", examine)
    reports = Reports(event=lambda words, _: said.append(words), deliver=deliver)
    with source_of(monkeypatch, kind, folder, [b"gx,gy\n" + ROWS, *steps]) as source:
        return WATCH.run([str(source.target)], RECIPE, WatchSettings(**{"idle": 3.0} | settings), reports), said


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """What stays in the folder of temporary files."""
    folder = tmp_path / "kept"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return lambda: sorted(folder.iterdir())


@pytest.mark.slow("reads a hundred streams")
@rows("kind", SOURCES, ids=[kind.__name__ for kind in SOURCES])
def test_what_came_is_analyzed_however_a_stream_ends(tmp_path, monkeypatch, clock, kept, kind):
    sent = np.loadtxt(_LINES, delimiter=",")
    for name, (steps, more) in ENDS.items():
        study, said = ended(monkeypatch, kind, tmp_path / name, steps)
        for channel, wanted in zip(study, sent.T, strict=True):
            values = channel.record.values[np.isfinite(channel.record.values)]
            assert len(values) >= FEW + more, (name, said)
            assert np.isin(values, [*wanted, 0.1, 0.0]).all(), name
        turned = kind is File and any(step in ("cut", "turn") for step in steps)
        assert ("rotated" in {finding.name for finding in study.findings}) == turned, name
        assert not kept(), name


@rows("kind", SOURCES, ids=[kind.__name__ for kind in SOURCES])
def test_a_watch_ends_in_every_state(tmp_path, monkeypatch, clock, kept, kind):
    """By the time, by hand, where no one writes or the source is gone; with nothing there is an error."""
    timed = {"duration": 1.0, "idle": math.inf}
    for number, (steps, settings) in enumerate(((["leave"], timed), ([], timed), (["leave"], {}))):
        study, _ = ended(monkeypatch, kind, tmp_path / str(number), steps, **settings)
        assert study[0].record.size == FEW
        with source_of(monkeypatch, kind, tmp_path / f"{number} silent", []) as source:
            watch = Watch(str(source.target), RECIPE, WatchSettings(**{"idle": 3.0} | settings))
            with watch.keeping(print):
                assert len(list(watch.events())) <= 2
                refused(al.DataError, "sent no samples", watch.study)
    assert not kept()


def test_lines_stay_where_a_result_could_not_be_written_and_come_only_once(tmp_path, monkeypatch, clock, kept):
    def full(_):
        raise al.UsageError("cannot be written")

    for kind in SOURCES:
        how = monkeypatch, kind, tmp_path / kind.__name__, [], full
        refused(al.UsageError, "cannot be written", lambda how=how: ended(*how))
        assert len(kept()) == (kind is not File)
        for file in kept():
            assert file.read_bytes().count(b"\n") == FEW + 1
            file.unlink()


def test_choices_are_judged_before_the_first_sample(tmp_path):
    for recipe, settings in (
        ({"average": 1e9}, {}), ({"average": 1e308}, {}), ({"average": 60.0}, {"duration": 3600.0}),
        ({"start": 7200.0}, {"duration": 3600.0}), ({"to": ("ug",)}, {}), ({"to": ("deg/h", "ug")}, {}),
        ({}, {"accuracy": 0.0}), ({}, {"accuracy": math.nan}), ({}, {"accuracy": 1e308}),
    ):  # fmt: skip
        Watch("port", al.Recipe(rate=100.0, unit="1", scale="0.01deg/s", to=("deg/h",)))
        words = "at most|between|no channel has a coefficient"
        choices = {"rate": 100.0, "unit": "deg/s"} | recipe
        refused(al.UsageError, words, lambda c=choices, s=settings: Watch("port", al.Recipe(**c), WatchSettings(**s)))


def test_wrong_targets_are_refused_in_words(tmp_path):
    for target, words in (
        (str(tmp_path), "is a folder"), ("udp://127.0.0.1:99999", "no address"), ("udp://[::1", "no address"),
        ("udp://192.168.1.5:9000", "this machine only, not at '192.168.1.5'"), ("udp://127.0.0.1", "no address to"),
        ("udp://example.com:9000", "only, not at 'example.com'"), ("tcp://127.0.0.1:9000", "no address"),
        ("no such file", "cannot be watched: No such file"), ("udp://127.0.0.1:0", "no address"),
        ("a\0b", "cannot be watched"), ("udp://a\0b:9000", "this machine only"),
    ):  # fmt: skip
        refused(al.AllaniteError, words, lambda t=target: live.opened(t, 9600))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        taken = f"udp://127.0.0.1:{other.getsockname()[1]}"
        refused(al.DataError, "cannot be watched", lambda: live.opened(taken, 9600))
    if os.path.exists("/dev/full"):
        refused(al.UsageError, "a device or a pipe", lambda: Spool("port", "/dev/full"))


def test_a_source_that_does_not_answer_does_not_hold_the_end(monkeypatch):
    """A thread that never comes back is left to itself, and an error in it is no silence."""
    monkeypatch.setattr(live, "WAIT", 0.001)
    silent = live.Feed(live.Tap(lambda _: threading.Event().wait() or b"", lambda: None))
    assert silent.close() == []
    broken = live.Feed(live.Tap(lambda _: 1 // 0 or b"", lambda: None))
    broken.thread.join()
    refused(ZeroDivisionError, "division", lambda: broken.take(1.0))
