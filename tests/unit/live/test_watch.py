"""allanite watch: a simulated sensor through a pseudo-terminal and by datagrams, moved once, unplugged once."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from allanite.live.lines import Lines, places
from allanite.live.sources import opened
from allanite.live.watching import Watch, WatchSettings, lasting
from click.testing import CliRunner

import allanite as al
from allanite.cli import main
from allanite.reporting import table

RATE = 1000
HOW = ["--rate", str(RATE), "--unit", "deg/h", "--refresh", "1"]


def lines_of(values):
    return "".join(f"{value:.5f}\n" for value in values).encode()


def begun(target, *options):
    command = [sys.executable, "-m", "allanite.cli", "watch", target, *HOW, *map(str, options)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def sensor():
    """At rest, moved for a second, at rest."""
    rng = np.random.default_rng(1)
    return rng.normal(size=30_000), 300.0 * rng.normal(size=RATE), rng.normal(size=10_000)


def told(process, words):
    """What it says until it says that."""
    said = ""
    for line in process.stderr:
        said += line
        if words in line:
            return said
    raise AssertionError(f"ended without {words!r}: {said}")


def ended(process, how=signal.SIGTERM):
    process.send_signal(how)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return err


def checked(study, err, *, size):
    (channel,) = study["channels"]
    assert "the sensor moves at" in err
    assert "oadev" in err
    findings = {one["name"]: one for one in channel["quality"]["findings"]}
    start, end = findings["moving"]["place"]
    assert 29 < start <= 30
    assert 31 <= end < 32.5
    assert channel["size"] >= size
    N = next(one for one in channel["fit"]["terms"] if one["symbol"] == "N")
    assert N["shown"]["value"] == pytest.approx(1 / np.sqrt(RATE) / 60, rel=0.03)
    assert channel["curves"][0]["deviation"][0] == pytest.approx(np.deg2rad(1 / 3600), rel=0.03)


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
    with pytest.raises(OSError, match="the device is gone"):
        tap.take(1.0)
    tap.close()


@pytest.mark.skipif(os.name == "nt", reason="a pseudo-terminal")
def test_through_a_terminal_moved_unplugged_and_ended(tmp_path):
    pytest.importorskip("serial", reason="the extra 'live'")
    import tty

    port, result = tmp_path / "port", tmp_path / "out.json"

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
    watch = begun(str(port), "--json", result)
    said = told(watch, "watching")
    for part in sensor():
        send(part)
    for end in ends:
        os.close(end)
    said += told(watch, "is gone")
    ends = plugged()
    said += told(watch, "is back")
    send(sensor()[2])
    time.sleep(1.0)
    err = said + ended(watch)
    study = json.loads(result.read_text())
    checked(study, err, size=45_000)
    assert "is gone" in err
    assert "is back" in err
    assert [one["name"] for one in study["findings"]] == ["unplugged"]
    assert "gaps" in {one["name"] for one in study["channels"][0]["quality"]["findings"]}


@pytest.mark.slow("long streams")
def test_datagrams_and_interruption(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    result, curve = tmp_path / "out.json", tmp_path / "out.csv"
    watch = begun(f"udp://127.0.0.1:{port}", "--json", result, "--csv", curve)
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with line:
        line.connect(("127.0.0.1", port))
        said = told(watch, "watching")
        line.send(b"gz\n")
        for part in np.array_split(np.concatenate(sensor()), 410):
            line.send(lines_of(part))
            time.sleep(0.005)
        err = said + ended(watch, signal.SIGINT)
    checked(json.loads(result.read_text()), err, size=40_000)
    assert curve.read_text().startswith("channel,statistic,m")


def test_what_a_short_stream_lacks_is_reported(tmp_path):
    path = tmp_path / "log.txt"
    path.write_bytes(lines_of(np.random.default_rng(3).normal(size=20)))
    watch = Watch(str(path), al.Recipe(rate=RATE, unit="deg/h"), WatchSettings(idle=0.1))
    for _ in watch.events():
        pass
    assert watch.report().startswith("column 1: 0 s; 0 samples are too few for noise coefficients")


@pytest.mark.slow("long streams")
def test_a_file_that_grows_gives_what_analyze_gives(tmp_path):
    path, values = tmp_path / "log.csv", np.random.default_rng(2).normal(size=(20_000, 2))
    stamps = np.arange(20_000) / 100.0
    stamps[15_000:] += 30.0
    rows = [f"{t:.2f},{a:.5f},{b:.5f}\n" for t, (a, b) in zip(stamps, values.tolist(), strict=True)]
    path.write_text("t,x,y\n" + "".join(rows[:100]) + rows[100][:7])
    recipe = al.Recipe(rate=100.0, unit="deg/h", time="t")
    watch = Watch(str(path), recipe, WatchSettings(idle=0.5, every=1e9))
    events = watch.events()
    assert "watching" in next(events)
    with path.open("a") as file:
        file.write(rows[100][7:] + "".join(rows[101:]))
    assert list(events) == []
    study = watch.study()
    assert [channel.record.name for channel in study] == ["x", "y"]
    batch = al.identify(al.Record(values[:, 0], 100.0, "deg/h"))
    assert study["x"].fit["N"].value == pytest.approx(batch["N"].value, rel=0.02)
    assert study["x"].quality.names == ("gaps",)
    assert "3000 of 23000" in study["x"].quality.findings[0].what
    assert "watched as a stream" in table(study)
    assert al.from_dict(study.to_dict()).channels[1].fit["N"].value == study["y"].fit["N"].value


def watched(values, rate=100.0, unit="deg/h", kind=None):
    """Everything that is said of these values, and the study."""
    watch = Watch("-", al.Recipe(rate=rate, unit=unit, kind=kind), WatchSettings())
    text = "".join(f"{value!r}\n" for value in np.asarray(values).tolist()).encode()
    said = [words for at in range(0, len(text), 9973) for words in watch._take(text[at : at + 9973])]
    return said, watch.study()[0]


@pytest.mark.parametrize("at", [7, 33_333])
def test_outliers_are_replaced_counted_and_said(at):
    clean = np.random.default_rng(3).normal(size=60_000)
    spiky = clean.copy()
    spiky[[at, 40_000, 55_555]] += 1000.0, -8.0, 3000.0
    said, channel = watched(spiky)
    assert [words for words in said if "outlier" in words] == [
        f"column 1: outlier at {at / 100:.6g} s; it is replaced, and so are further ones"
    ]
    (finding,) = [one for one in channel.quality.findings if one.name == "outliers"]
    assert finding.what == f"3 outliers, the first at {at / 100:.6g} s, are replaced by the medians of their blocks"
    (_, plain) = watched(clean)
    assert "outliers" not in plain.quality.names
    np.testing.assert_allclose(channel.curve.deviation, plain.curve.deviation, rtol=0.02)
    np.testing.assert_array_equal(channel.curve.count, plain.curve.count)
    assert "moving" not in channel.quality.names
    assert "gaps" not in channel.quality.names


@pytest.mark.slow("long streams")
def test_a_step_is_said_when_it_comes_and_noise_has_none():
    noise = al.simulate(al.N(1, "deg/h*sqrt(s)") + al.B(0.3, "deg/h") + al.K(1, "deg/h/sqrt(h)"), 200_000, 100.0,
                        rng=np.random.default_rng(4))  # fmt: skip
    values = np.rad2deg(noise.values) * 3600
    assert watched(values)[0] == []
    values[123_450:] += 15.0
    said, channel = watched(values)
    assert len(said) == 1
    assert said[0].startswith("column 1: the mean jumps at 1234 s, by ")
    assert "analyze what was recorded before it and after it separately" in said[0]
    (finding,) = [one for one in channel.quality.findings if one.name == "step"]
    assert finding.place == (1234.0, 1235.0)


def test_an_angle_is_watched_as_its_steps():
    rates = np.random.default_rng(5).normal(size=30_000)
    angle = np.concatenate(([5.0], 5.0 + np.cumsum(rates) / 100.0))
    (_, channel), (_, plain) = watched(angle, unit="deg", kind="angle"), watched(rates, unit="deg/s")
    assert channel.curve.m.size == plain.curve.m.size
    np.testing.assert_allclose(channel.curve.deviation, plain.curve.deviation, rtol=1e-9)
    np.testing.assert_allclose(channel.fit["N"].value, plain.fit["N"].value, rtol=1e-6)


@pytest.mark.slow("long streams")
def test_it_foretells_when_more_is_known():
    model = al.N(1, "deg/h*sqrt(s)") + al.B(1, "deg/h")
    record = al.simulate(model, 60_000, 10.0, rng=np.random.default_rng(1))
    watch = Watch("-", al.Recipe(rate=10.0, unit=record.unit, kind=record.kind), WatchSettings(accuracy=0.005))
    assert list(watch._take(lines_of(record.values))) == []
    words = watch.report()
    assert "more until B is known to 0.5 %" in words
    needed = al.plan(watch.fit(watch.monitors["column 1"]).model, 10.0, durations=(), accuracy=0.005)
    left = needed.needed[needed.names.index("B")] - watch.monitors["column 1"].stream.size / 10.0
    assert f"about {lasting(left)} more until B" in words


@pytest.mark.parametrize(
    ("target", "says"),
    [
        ("udp://192.168.1.5:9000", "from this machine only, not at '192.168.1.5'"),
        ("udp://0.0.0.0:9000", "from this machine only, not at '0.0.0.0'"),
        ("udp://example.com:9000", "from this machine only, not at 'example.com'"),
        ("udp://127.0.0.1", "no address to listen at"),
        ("tcp://127.0.0.1:9000", "no address to listen at"),
        ("no such file", "cannot be watched: No such file"),
    ],
)
def test_other_sources_are_refused(target, says):
    done = CliRunner().invoke(main, ["watch", target, *HOW])
    assert done.exit_code in (2, 3)
    assert says in done.stderr


def test_choices_are_refused_before_anything_is_read(tmp_path):
    path = tmp_path / "log.txt"
    path.write_text("1 2\n3 4\n")
    for options, says in (
        (["--rate", "1"], "a stream does not say its unit: give --unit"),
        (["--unit", "deg/h"], "a stream does not say its rate: give --rate"),
        ([], "a stream does not say its rate and unit: give --rate and --unit"),
        ([*HOW, "--statistic", "theo1"], "a stream has no 'theo1'"),
        ([*HOW, "--channels", "7", "--idle", "0.1"], "no column '7'; columns: 1: column 1, 2: column 2"),
        ([*HOW, "--idle", "0.1"], "2 samples are too few"),
    ):
        done = CliRunner().invoke(main, ["watch", str(path), *options])
        assert done.exit_code in (2, 3), says
        assert says in done.stderr


def test_rows_of_torn_and_bad_lines():
    lines = Lines()
    assert lines.rows(b"# a comment\ngx [deg/h],gy [deg/h]\n1, 2\n3") == [[1.0, 2.0]]
    assert lines.rows(b"0,4\r\nx,y\n5\n") == pytest.approx(
        np.array([[30.0, 4.0], [np.nan] * 2, [np.nan] * 2]), nan_ok=True
    )
    assert (lines.names, lines.bad) == (("gx", "gy"), 2)
    assert places(lines, ["gy"], "1") == ({"gy": 1}, 0)
    with pytest.raises(al.UsageError, match="no lines"):
        lines.rows(b"1" * 100_000)


def test_a_port_that_is_taken_is_refused():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        with pytest.raises(al.DataError, match="cannot be watched"):
            opened(f"udp://127.0.0.1:{other.getsockname()[1]}", 9600)
