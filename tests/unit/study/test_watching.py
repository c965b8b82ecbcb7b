"""allanite watch: what is analyzed of a file, also while it comes; moved once, unplugged once, with torn lines."""

import errno
import gc
import gzip
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.phrases.phrase import duration
from allanite.prepare import quality
from allanite.readers.live import BreakError, ReturningSource, opened
from allanite.readers.spool import LONGEST_ROW, Spool
from allanite.study.watching import AT_ONCE, CHECKS, REPORTS, Task, Watch, WatchSettings
from allanite.web.requests import Request

RATE = 1000
HOW = ["--rate", str(RATE), "--unit", "deg/h", "--refresh", "1"]
RECIPE = al.Recipe(rate=100.0, unit="deg/h")


def lines_of(values):
    return "".join(f"{value:.5f}\n" for value in values).encode()


def noise(size, seed=3):
    return np.random.default_rng(seed).normal(size=size)


def written(folder, values):
    path = folder / "log.txt"
    path.write_bytes(lines_of(values))
    return path


@pytest.mark.skipif(os.name == "nt", reason="select on a pipe")
def test_a_line_without_an_other_end_is_gone(monkeypatch):
    """A pipe stands in for the line."""
    serial = pytest.importorskip("serial", reason="the extra 'live'")
    ends = os.pipe()
    port = SimpleNamespace(fd=ends[0], close=lambda: os.close(ends[0]))
    monkeypatch.setattr(serial, "Serial", lambda *_, **__: port)
    tap = opened("/dev/null", 9600)
    os.write(ends[1], b"1.5\n")
    assert (tap.take(1.0), tap.take(0.0)) == (b"1.5\n", b"")
    os.close(ends[1])
    refused(OSError, "the device is gone", lambda: tap.take(1.0))
    tap.close()


def told(process, words):
    """What it says until it says that."""
    said = ""
    while words not in said:
        line = process.stderr.readline()
        assert line, f"ended without {words!r}: {said}"
        said += line
    return said


def arrived(path, count):
    """Wait until so many lines are kept."""
    while not path.exists() or path.read_bytes().count(b"\n") < count:
        time.sleep(0.01)


@pytest.mark.slow("a process that watches a terminal")
@pytest.mark.skipif(os.name == "nt", reason="a pseudo-terminal")
def test_through_a_terminal_moved_unplugged_and_ended(tmp_path):
    pytest.importorskip("serial", reason="the extra 'live'")
    import tty

    port, result, kept = tmp_path / "port", tmp_path / "out.json", tmp_path / "kept.txt"

    def plugged():
        ends = os.openpty()
        tty.setraw(ends[1])
        port.unlink(missing_ok=True)
        port.symlink_to(os.ttyname(ends[1]))
        return ends

    def send(values):
        for part in np.array_split(values, max(1, values.size // 200)):
            os.write(ends[0], lines_of(part))

    ends = plugged()
    words = [sys.executable, "-m", "allanite.cli", "watch", port, *HOW, "--json", result, "--record", kept]
    watch = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = told(watch, "watching")
    for part in (noise(30_000), 300.0 * noise(RATE, 4), noise(10_000, 5)):  # at rest, moved for a second, at rest
        send(part)
    arrived(kept, 41_000)
    for end in ends:
        os.close(end)
    said += told(watch, "is gone")
    ends, back = plugged(), threading.Event()

    def knock():  # what comes before the port is opened is lost
        while not back.wait(0.05):
            os.write(ends[0], b"0.5\n")

    knocking = threading.Thread(target=knock)
    knocking.start()
    said += told(watch, "is back")
    back.set()
    knocking.join()
    before = kept.read_bytes().count(b"\n")
    send(noise(10_000, 6))
    arrived(kept, before + 10_000)
    watch.send_signal(signal.SIGTERM)
    said += watch.communicate(timeout=300)[1]
    assert watch.returncode == 0, said
    study = json.loads(result.read_text())
    assert [finding["name"] for finding in study["findings"]] == ["unplugged"]
    (channel,) = study["channels"]
    assert re.search("moved in 1 place, from (3|29)", said)
    assert any(line.startswith("moved in 1 place, from ") and "left out" in line for line in channel["history"])
    assert channel["size"] >= before + 10_000
    assert "gaps" in {finding["name"] for finding in channel["quality"]["findings"]}
    (N,) = (term for term in channel["fit"]["terms"] if term["symbol"] == "N")
    assert N["shown"]["value"] == pytest.approx(1 / np.sqrt(RATE) / 60, rel=0.03)
    assert channel["curves"][0]["deviation"][0] == pytest.approx(np.deg2rad(1 / 3600), rel=0.03)


class Direct:
    """A feed without a thread of its own."""

    def __init__(self, tap):
        self.take, self.tap = tap.take, tap

    def close(self):
        self.tap.close()
        return []


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    """A file is taken as fast as it can be, and the time goes on only where nothing has come."""
    at = SimpleNamespace(now=0.0)
    fast = SimpleNamespace(monotonic=lambda: at.now, sleep=lambda seconds: setattr(at, "now", at.now + seconds))
    for room in ("allanite.study.watching", "allanite.readers.live"):
        monkeypatch.setattr(f"{room}.time", fast)
    monkeypatch.setattr("allanite.study.watching.Feed", Direct)
    return at


def watching(path, recipe=RECIPE, **settings):
    """The watch of a file."""
    return closing(Watch(str(path), recipe, WatchSettings(**{"idle": 0.1} | settings)))


def watched(path, recipe=RECIPE):
    """The study of a file that is watched."""
    with watching(path, recipe) as watch:
        list(watch.events())
        return watch.study()


def test_what_a_short_stream_lacks_is_reported(tmp_path):
    with watching(written(tmp_path, noise(20))) as watch:
        assert len(list(watch.events())) == 1
        assert "20 samples are too few" in watch.report()
        refused(al.DataError, "20 samples are too few", watch.study)
    assert not Path(watch.spool.path).exists()


@pytest.mark.slow("takes more than half a second")
@rows(("kind", "outliers"), [("rate", None), ("angle", "mark"), ("rate", "keep")])
def test_watch_is_analyze_of_what_came(tmp_path, kind, outliers):
    values = noise(20_000)
    values[[7, 14_000]] += 1000.0, -8.0
    path = written(tmp_path, np.cumsum(values) / 100 if kind == "angle" else values)
    unit = "deg" if kind == "angle" else "deg/h"
    recipe = al.Recipe(rate=100.0, unit=unit, kind=kind, outliers=outliers, average=0.02, start=10.0)
    study = watched(path, recipe)
    assert study.to_dict()["channels"] == al.analyze(path, recipe).to_dict()["channels"]
    assert "watched as a stream" in study.notes


@pytest.mark.slow("long streams")
@rows(("size", "words"), [(0.0, ""), (3.0, "the bias steps: +"), (15.0, "the bias steps: +14.6 deg/h at 1234 s")])
def test_a_step_is_reported_and_noise_has_none(tmp_path, size, words):
    model = al.N(1, "deg/h*sqrt(s)") + al.B(0.3, "deg/h") + al.K(1, "deg/h/sqrt(h)")
    values = np.rad2deg(al.simulate(model, 200_000, 100.0, rng=4).values) * 3600
    values[123_450:] += size
    with watching(written(tmp_path, values)) as watch:
        list(watch.events())
        report = watch.report()
    assert words in report
    assert words or not re.search("steps|jumps", report)


@pytest.mark.slow("long streams")
def test_it_foretells_when_more_is_known(tmp_path):
    model = al.N(1, "deg/h*sqrt(s)") + al.B(1, "deg/h")
    values = np.rad2deg(al.simulate(model, 60_000, 10.0, rng=1).values) * 3600
    with watching(written(tmp_path, values), replace(RECIPE, rate=10.0), accuracy=0.005) as watch:
        assert len(list(watch.events())) == 1
        words = watch.report()
        fit = watch.study()[0].fit
    assert "more until B is known to 0.5 %" in words
    needed = al.plan(fit, 10.0, durations=(), accuracy=0.005)
    left = needed.searched_needed[needed.names.index("B")] - 6000.0
    assert f"about {duration(float(f'{left:.2g}'))} more until B" in words


@pytest.mark.slow("takes more than half a second")
def test_motion_is_left_out_by_default_and_refused_if_asked(tmp_path):
    values = noise(30_000, 6)
    values[10_000:13_000] *= 300.0
    path = written(tmp_path, values)
    study = watched(path)
    assert study.to_dict()["channels"] == al.analyze(path, replace(RECIPE, motion="mark")).to_dict()["channels"]
    assert study[0].fit["N"].value == pytest.approx(np.deg2rad(1 / 3600) / 10, rel=0.05)
    for job in (watched, al.analyze):
        refused(al.DataError, "from 100 s", lambda job=job: job(path, replace(RECIPE, motion="refuse")))


@pytest.mark.slow("takes more than half a second")
def test_what_came_is_kept_if_asked(tmp_path):
    path, kept = tmp_path / "log.csv", tmp_path / "kept.csv"
    path.write_bytes(b"gx [deg/h]\n" + lines_of(noise(2000)))
    words = ["watch", path, "--rate", "100", "--idle", "0.1", "--record", kept]
    run(*words, code=0)
    assert kept.read_bytes() == path.read_bytes()
    ends(run(*words), 2, "kept.csv' already exists")
    run(*words, "--force", code=0)
    before = path.read_bytes()
    ends(run(*words[:-1], path, "--force"), 2, "--record would overwrite the input")
    assert path.read_bytes() == before


def test_the_page_names_no_file_to_write():
    refused(al.UsageError, "unknown key 'record'", lambda: Request.of("watch", {"record": "lines.txt"}))


@pytest.mark.slow("takes more than half a second")
def test_a_full_disk_ends_the_stream_with_what_came(tmp_path, monkeypatch):
    limit, real = 100_000, Spool.__init__

    def small(spool, *args, **options):
        real(spool, *args, **options)
        file = spool._file

        def write(data):
            room = limit - os.fstat(file.fileno()).st_size
            if room <= 0:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return file.write(data[:room])

        spool._file = SimpleNamespace(write=write, truncate=file.truncate, seek=file.seek, close=file.close)

    monkeypatch.setattr(Spool, "__init__", small)
    with watching(written(tmp_path, noise(30_000)), idle=0.5) as watch:
        said = list(watch.events())
        study = watch.study()
    assert "takes no more lines (No space left on device); the stream ends here" in said[1]
    assert "disk" in {finding.name for finding in study.findings}
    assert 0 < study[0].record.size < 30_000
    assert study[0].fit["N"].status == "identified"


def test_the_time_without_a_port_is_a_gap_from_the_first_second_on(clock):
    """A device that is gone before anything was looked at: the rate is found then."""
    with watching("port", idle=5.0) as watch:
        watch.spool = Spool("port")
        watch.spool.add(lines_of(noise(1000)))
        assert "is gone (unplugged)" in next(watch._broken(BreakError("gone", "unplugged")))
        clock.now += 0.5
        back = BreakError("back")
        assert list(watch._broken(back)) == ["'port' is back; 50 samples are missing"]
        watch.spool.keep([back])
        assert Path(watch.spool.path).read_bytes().splitlines().count(b"nan") == 50


class Clock:
    """A port that sends a hundred rows of a hundred hertz with each second of a clock that goes as fast as it can."""

    def __init__(self, monkeypatch, seconds, stamp=None):
        self.now, self.seconds, self.stamp, self.rng = 0.0, seconds, stamp, np.random.default_rng(1)
        clock = SimpleNamespace(monotonic=lambda: self.now, sleep=self.sleep)
        monkeypatch.setattr("allanite.study.watching.time", clock)
        monkeypatch.setattr("allanite.study.watching.opened", lambda *_: SimpleNamespace(live=True))
        monkeypatch.setattr("allanite.study.watching.Feed", lambda _: self)
        monkeypatch.setattr("allanite.readers.live.time", clock)

    def sleep(self, seconds):
        self.now += seconds

    def take(self, _):
        self.now += 1.0
        if self.now > self.seconds:
            return b""
        values = self.rng.normal(size=100).tolist()
        if self.stamp is None:
            return lines_of(values)
        times = self.stamp(self.now + np.arange(100) / 100.0).tolist()
        return "".join(f"{t!r},{value:.5f}\n" for t, value in zip(times, values, strict=True)).encode()

    def close(self):
        return []


def watch_of(recipe=RECIPE, **settings):
    return closing(Watch("port", recipe, WatchSettings(**{"every": 1e9} | settings)))


@rows("settings", [{"duration": 0.5}, {"idle": 0.5}], ids=["for", "idle"])
def test_a_watch_ends_in_time_while_its_port_is_gone(monkeypatch, settings):
    def gone(*_):
        raise OSError("the device is gone")

    source = Clock(monkeypatch, 0)
    taps = iter([SimpleNamespace(take=gone, close=list)])
    source.take = ReturningSource(lambda: next(taps, None) or gone()).take
    with watch_of(**settings) as watch:
        assert "is gone" in list(watch.events())[1]
    assert source.now == pytest.approx(0.6)


def test_the_time_of_a_report_is_no_silence(monkeypatch):
    """Lines that come while something is computed end no watch that waits for a short time only."""
    source = Clock(monkeypatch, 40)

    def look(_):
        source.sleep(3.0)
        source.seconds += 3.0
        return iter(())

    monkeypatch.setattr(Watch, "_look", look)
    with watch_of(idle=2.0) as watch:
        list(watch.events())
        assert watch.spool.rows == 4000


@rows("jump, words", [
    (1e7, r"jump by 1e\+07 s before row"), (1e18, r"jump by 1e\+18 s before row"),
    (1e300, r"jump by 1e\+300 s before row"), (-1e7, "is earlier than the previous one"),
    (np.nan, "has no time stamp in 100 of"),
])  # fmt: skip
def test_time_stamps_that_jump_are_named_at_once_and_the_lines_are_kept(monkeypatch, jump, words):
    monkeypatch.setattr("allanite.study.watching.RECENT", 4.0)  # later on there are only rows after the jump
    source = Clock(monkeypatch, 12, lambda times: np.where(times > 5.995, times + jump, times))
    with watch_of(al.Recipe(unit="deg/h", time="1"), duration=13) as watch:
        events = watch.events()
        said = next(said for said in events if "cannot be analyzed" in said)
        assert re.search(f"the last rows cannot be analyzed: .*{words}", said)
        assert source.now == 6.0
        list(events)
        with pytest.raises(al.DataError, match=r"came, kept in '.*', cannot .* time stamp") as refusal:
            watch.study()
    kept = Path(str(refusal.value).split("'")[1])
    many = kept.read_bytes().count(b"\n")
    kept.unlink()
    assert many == 1200


@pytest.mark.slow("long streams")
def test_a_long_watch_takes_no_more_memory_than_a_short_one(monkeypatch):
    """Rows beyond the last ones are on the disk, and what was said is kept once."""
    monkeypatch.setattr("allanite.readers.spool.TAIL", 500)
    monkeypatch.setattr("allanite.study.watching.RECENT", 2.0)
    sizes = []
    for seconds in (10, 10, 120):  # the first one is for what is made once
        Clock(monkeypatch, seconds)
        tracemalloc.start()
        with watch_of(duration=seconds) as watch:
            list(watch.events())
            assert watch.spool.rows >= 100 * (seconds - 1)
            gc.collect()
            sizes.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
    assert sizes[2] < sizes[1] + 30_000, sizes


def grown(kind):
    """Lines of a file, and how it is read."""
    values, times = np.random.default_rng(5).normal(size=(9000, 2)), np.arange(9000) / 100
    if kind == "angle":
        values = np.cumsum(values, axis=0)
    if kind == "stamps":
        times[4500:] += 20
        values[7000:7010] = np.nan
    if kind in ("stamps", "midnight"):
        days = np.array(["2026-01-01T23:59:30"], "M8[ms]") + np.rint(1e3 * times).astype("m8[ms]")
        first = [str(day)[11:] for day in days] if kind == "midnight" else times.tolist()
        return [f"{t},{a:.5f},{b:.5f}\n" for t, (a, b) in zip(first, values.tolist(), strict=True)], {"time": "1"}
    return [f"{a:.5f},{b:.5f}\n" for a, b in values.tolist()], {"rate": 100.0}


@pytest.mark.slow("takes more than half a second")
@rows(("kind", "choices"), [
    ("rate", {}), ("rate", {"average": 0.03, "start": 5.0, "exclude": ((20.0, 21.0),)}),
    ("angle", {"kind": "angle", "unit": "deg"}), ("stamps", {}), ("midnight", {}),
])  # fmt: skip
def test_sums_that_are_carried_on_are_those_of_the_file_in_parts(tmp_path, monkeypatch, kind, choices):
    """From report to report, however short, with blocks that are shorter than usual."""
    monkeypatch.setattr("allanite.prepare.inspector.BLOCK", 1024)
    path, (lines, how) = tmp_path / "log.csv", grown(kind)
    path.write_text("".join(lines))
    recipe = al.Recipe(**({"unit": "deg/h", "memory": "1kB", "motion": "mark", "outliers": "keep"} | how | choices))
    watch = Watch(str(path), recipe)
    watch.spool = Spool(str(path), sent=False)
    with closing(watch):
        begin = 0
        for end in (2500, 2503, 4700, 9000):
            watch.spool.add("".join(lines[begin:end]).encode())
            said, begin = list(watch._news()), end
            assert ("sums to which" in said[0]) == (end == 2500)
        assert sum(len(piece[1][0]) for piece in watch.passing.pieces) < 4500
        mine = watch.study()
    whole = al.analyze(path, recipe)
    assert mine.provenance == whole.provenance
    assert mine.to_dict()["channels"] == whole.to_dict()["channels"]


@pytest.mark.slow("takes more than half a second")
def test_the_last_result_is_of_all_samples_where_they_fit(tmp_path, monkeypatch):
    monkeypatch.setattr("allanite.study.watching.BUDGET", 1)
    path, recipe = written(tmp_path, noise(3000)), replace(RECIPE, motion="mark")
    with watching(path, recipe) as watch:
        list(watch.events())
        assert ["sums" in said for said in watch._news()] == [True, False]
        assert watch.latest.notes != watch.study().notes
        assert watch.study().to_dict()["channels"] == al.analyze(path, recipe).to_dict()["channels"]
    refused(al.UsageError, "has no 'theo1'", lambda: watched(path, replace(recipe, memory="1kB", statistic="theo1")))


def test_a_look_makes_the_findings_of_an_inspection_that_are_said_at_once():
    y, told = noise(6400, 7), set[str]()
    for first, last, new in ((0, 0, 0.0), (100, 101, 50.0), (300, 400, 1.0), (3000, 4000, 300.0 * y[:1000])):
        values = y.copy()
        values[first:last] = new
        for record in (al.Record(v, 100.0, "deg/h") for v in (values, np.clip(values, -1, 1))):
            every, mine = quality.inspect(record).findings, quality.checked(record, CHECKS).findings
            wanted = [finding for finding in every if finding.name in AT_ONCE]
            assert [finding for finding in mine if finding.name in AT_ONCE] == wanted
            told |= {finding.name for finding in wanted}
    assert told == {*AT_ONCE} - {"missing samples"}


def test_reports_are_as_far_apart_as_the_record_is_long():
    """As many as the logarithm of the record, then one an hour; those that are asked for are evenly spaced."""
    for reports, many in ((REPORTS, 290), ((3600.0, 3600.0), 167)):
        task, count = Task(lambda: iter(()), *reports, 0.0), 0
        for now in range(0, 7 * 86400, 5):
            if task.due(now, 200 * now):
                task.done(now, now, 200 * now)
                count += 1
        assert abs(count - many) < 10
    task.done(0.0, 1000.0, 1)  # it took a thousand seconds
    assert [task.due(now, 10**9) for now in (9999.0, 10000.0)] == [False, True]


@pytest.mark.slow("takes more than half a second")
def test_an_analysis_that_failed_is_not_replaced_by_the_one_before(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,x\n" + "".join(f"{i / 100:.2f},{i % 7}\n" for i in range(1000)))
    with watching(path, al.Recipe(unit="deg/h", time="t")) as watch:
        list(watch.events())
        assert watch.study()[0].record.size == 1000
        watch.spool.add(b"1e9,1\n" * 1000)
        for _ in range(2):
            refused(al.DataError, "time stamps", watch.study)


@pytest.mark.slow("takes more than half a second")
def test_a_port_that_comes_and_goes_is_one_finding(monkeypatch):
    source = Clock(monkeypatch, 1000)
    take, due = source.take, [20.0, 40.0, 60.0]

    def torn(seconds):
        if due and source.now >= due[0]:
            raise OSError(f"the device is gone since {due.pop(0)} s")
        return take(seconds)

    source.take = ReturningSource(lambda: SimpleNamespace(take=torn, close=list)).take
    with watch_of(duration=100) as watch:
        assert sum("is gone" in said for said in watch.events()) == 3
        assert [finding.what for finding in watch.findings.values()] == ["'port' was gone 3 times"]


def test_choices_are_refused_in_the_words_of_analyze(tmp_path):
    path = tmp_path / "log.txt"
    path.write_text("1 2\n3 4\n" * 500)
    every = (["--statistic", "theo7"], ["--channels", "7"], ["--until", "1000"], ["--motion", "hide"])
    for options in (["--rate", "1"], ["--unit", "deg/h"], *([*HOW[:4], *words] for words in every)):
        watch = run("watch", path, *options, "--idle", "0.1")
        analyze = run("analyze", path, *options)
        assert watch.exit_code == analyze.exit_code > 1
        error = [line for line in analyze.stderr.splitlines() if line.strip() and not line.startswith("try: ")]
        assert error[-1] in watch.stderr, watch.stderr


def spooled(*parts, sent=True):
    spool = Spool("port", sent=sent)
    for part in parts:
        spool.add(part)
    spool.finish()
    text = Path(spool.path).read_bytes()
    spool.close()
    return text, spool


def test_torn_and_bad_lines_of_a_port_are_missing_samples():
    text, spool = spooled(b"0.7\n# a comment\ngx [deg/h],gy [deg/h]\n1, 2\n3", b"0,4\n", b"x,y\n5\n6,7,8\n9,10\n11,")
    assert text == b"# a comment\ngx [deg/h],gy [deg/h]\n1, 2\n30,4\nnan,nan\nnan,nan\nnan,nan\n9,10\n"
    assert spool.rows == 6
    assert spooled(b"1 2\n3 4\nx y\n3\n4 5", sent=False)[0] == b"1 2\n3 4\nx y\n3\n4 5\n"  # of a file
    assert spooled(*(bytes([byte]) for byte in b"gx [deg/s]\n1.5\n-2\n"))[0] == b"gx [deg/s]\n1.5\n-2\n"
    # rows that a reader takes are kept as they are
    long = b"7;" + b"1" * LONGEST_ROW + b"1\n1;2\n"
    text, _ = spooled(b"a;b\n0,1;0,2\n0,3;0,4\n1;\n# x\n", long, sent=False)
    assert text == b"a;b\n0,1;0,2\n0,3;0,4\n1;\n# x\nnan;nan\n1;2\n"
    spool = Spool("port")
    refused(al.UsageError, "no lines", lambda: spool.add(b"1" * 100_000))
    spool.close()
    # the last rows are read below the headings
    _, spool = spooled(b"t,gx\n" + b"".join(b"%d,%d\n" % (i, i) for i in range(100)))
    with spool.recent(2) as (path, before):
        assert (Path(path).read_bytes(), before) == (b"t,gx\n98,98\n99,99\n", 98)


def test_a_file_that_is_no_text_is_named_for_what_it_is(tmp_path):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(lines_of(noise(2000)), mtime=0))
    refused(al.DataError, "allanite analyze", lambda: watched(path))
    assert al.analyze(path, RECIPE)[0].fit is not None  # the cure
