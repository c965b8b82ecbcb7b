"""The system's faults: closed and full streams, a full disk, odd names, signals."""

import ast
import bz2
import gzip
import json
import lzma
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests import thinned
from tests.commands import ends, run
from tests.rows import paired, refused, rows

import allanite as al
from allanite.cli import streams
from allanite.reporting import to_csv

PROGRAM = shlex.join([sys.executable, "-m", "allanite.cli"])
linux = pytest.mark.skipif(sys.platform != "linux", reason="a shell with /dev/full")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A gyroscope at rest, as text."""
    path = tmp_path_factory.mktemp("in") / "a.csv"
    rate = 90 * np.random.default_rng(1).standard_normal(1000)
    columns = np.column_stack([np.arange(1000) / 20.0, rate])
    np.savetxt(path, columns, "%.6f", ",", header="t [s],gx [deg/h]", comments="")
    return path


def shell(line, **more):
    """Run a line of a shell."""
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False, timeout=120, **more)


@pytest.mark.slow("takes more than half a second")
@linux
@rows(("stream", "reason"), [(">/dev/full", "No space left on device"), (">&-", "it is closed")])
def test_a_stream_that_takes_nothing_is_named_and_the_other_output_is_written(file, tmp_path, stream, reason):
    done = shell(f"{PROGRAM} info {file} --json {tmp_path}/o.json {stream}")
    assert done.returncode == 3
    assert f"standard output cannot be written ({reason})" in done.stderr
    assert json.loads((tmp_path / "o.json").read_text())["type"] == "Study"


@linux
@rows("megabytes", thinned([200, 600, 1000, 2400], 1))
def test_too_small_an_address_space_is_named_before_the_work(file, megabytes):
    done = shell(f"ulimit -v {megabytes}000; {PROGRAM} analyze {file}")
    assert (done.returncode, done.stdout) == (3, "")
    assert "not enough memory: allanite needs about 2.5 GB of address space" in done.stderr


@pytest.mark.slow("takes more than half a second")
@linux
def test_a_file_that_does_not_fit_is_refused_before_it_is_read(tmp_path):
    large = tmp_path / "large.npy"
    np.lib.format.open_memmap(large, mode="w+", shape=(107_374_182,))  # a hole: it takes no room on the disk
    done = shell(f"ulimit -v 3000000; {PROGRAM} rate {large} --rate 100 --unit deg/h")
    assert done.returncode == 2
    assert re.search(r"the record may take 7\.73 GB of memory, of which [\d.]+ [GM]B may be used", done.stderr)


@pytest.mark.slow("takes more than half a second")
@linux
@rows("stream", ["2>/dev/full", "2>&-"])
def test_without_standard_error_the_exit_code_says_it(stream, tmp_path):
    assert shell(f"{PROGRAM} info {tmp_path}/none.csv {stream}").returncode == 3


@pytest.mark.slow("takes more than half a second")
@linux
def test_a_full_folder_for_copies_is_not_blamed_on_the_file(file, tmp_path):
    packed = tmp_path / "a.csv.gz"
    packed.write_bytes(gzip.compress(file.read_bytes() * 20))
    done = shell(f"ulimit -f 8; {PROGRAM} info {packed}", env={**os.environ, "TMPDIR": str(tmp_path)})
    assert done.returncode == 3
    assert f"no room for the .gz packing in the folder '{tmp_path}' (File too large)" in done.stderr
    assert "TMPDIR" in done.stderr


@pytest.mark.slow("takes more than half a second")
@linux
@rows("suffix", thinned(["csv", "npz", "parquet", "h5", "mat"], 2))
def test_a_file_that_may_not_become_so_large_is_named(tmp_path, suffix):
    target = tmp_path / f"x.{suffix}"
    done = shell(f"ulimit -f 8; {PROGRAM} simulate {target} --sensor mems --rate 20 --samples 20000")
    assert done.returncode == 2
    assert re.search("cannot be written .*File too large", done.stderr)
    assert not list(tmp_path.iterdir())


@rows("name, reason", [
    ("n" * 300 + ".json", "File name too long"), ("new/", "is a folder|Not a directory"),
    ("loop", "symbolic links|loop"),
])  # fmt: skip
def test_a_name_that_cannot_be_written_is_refused_before_the_work(file, tmp_path, name, reason):
    (tmp_path / "loop").symlink_to("loop")
    words = run("info", file, "--json", f"{tmp_path}/{name}", code=2).stderr
    assert re.search(reason, words)
    assert len(words) < 600


@linux
def test_a_recipe_is_a_regular_file(file, tmp_path):
    os.mkfifo(tmp_path / "recipe.toml")
    ends(run("analyze", file, "--recipe", tmp_path / "recipe.toml"), 2, "regular file")


@linux
def test_ctrl_c_once_more_ends_what_was_to_come_to_its_results(monkeypatch):
    """At once, unless the signal only came twice; other signals do not."""
    for period, number, again in (
        (0.0, signal.SIGINT, True),
        (9.0, signal.SIGINT, False),
        (0.0, signal.SIGTERM, False),
    ):
        monkeypatch.setattr(streams, "AGAIN_S", period)
        ended = False
        with streams.stopping() as stopped:
            assert not stopped()
            signal.raise_signal(number)
            try:
                signal.raise_signal(number)
            except KeyboardInterrupt:
                ended = True
            assert stopped()
        assert ended == again


def test_names_in_messages_and_tables_are_text():
    package = Path(al.__file__).parent
    doors = {
        "cli/streams.py",
        "readers/sandbox/worker.py",
        "readers/sandbox/xlsx_contents.py",
    }  # and what it reads from
    assert {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_bytes()))
        if isinstance(node, ast.Call)
        and re.fullmatch(r"print|click\.s?echo|sys\.std(out|err)(\.buffer)?\.write", ast.unparse(node.func))
    } == doors
    # a spreadsheet computes no name
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 1000, 20.0, rng=np.random.default_rng(1), name="=cmd|' /c calc'!A1")
    text = to_csv(al.analyze(al.Recording((record,))))
    assert "\n'=cmd|' /c calc'!A1," in text
    assert ",-0.5" in text or not re.search(r"(^|,)'-?\d", text)


@rows(("suffix", "pack"), [("gz", gzip.compress), ("bz2", bz2.compress), ("xz", lzma.compress)])
def test_packed_streams_are_read_whole_and_nothing_else_behind_them(file, tmp_path, suffix, pack):
    lines = file.read_bytes().splitlines(keepends=True)
    joined = tmp_path / f"joined.csv.{suffix}"
    joined.write_bytes(pack(b"".join(lines[:500])) + bytes(8 * (suffix == "xz")) + pack(b"".join(lines[500:])))
    assert al.read(joined)[0].size == 1000
    joined.write_bytes(pack(b"".join(lines)) + b"something else")
    refused(al.DataError, f"the .{suffix} packing is damaged", lambda: al.read(joined))


HELD = """
import importlib, signal, sys
from allanite.cli import main
room, _, name = sys.argv.pop(1).rpartition(".")

def held(*_, **__):
    print("held", file=sys.stderr, flush=True)
    while True:
        signal.pause()

setattr(importlib.import_module(room), name, held)
main()
"""


@linux
@pytest.mark.slow("processes that are ended")
@rows("number, where", [
    (signal.SIGTERM, "allanite.readers.sandbox.packing.head_of"), (signal.SIGHUP, "shutil.copyfileobj"),
    (signal.SIGTERM, "os.replace"), (signal.SIGHUP, "os.replace"),
])  # fmt: skip
def test_a_program_that_is_ended_leaves_nothing(file, tmp_path, number, where):
    """While its input is copied or read, and before what it has written gets its name."""
    for folder in ("copies", "out"):
        (tmp_path / folder).mkdir()
    environment = {**os.environ, "TMPDIR": str(tmp_path / "copies")}
    words = [sys.executable, "-c", HELD, where, "analyze", "-", "--csv", str(tmp_path / "out" / "o.csv")]
    with file.open("rb") as lines, subprocess.Popen(
        words, env=environment, stdin=lines, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # noqa: PLW1509 - nohup ignores it
    ) as running:  # fmt: skip
        said = iter(running.stderr.readline, b"")
        assert b"held\n" in said
        running.send_signal(number)
        rest = running.stderr.read()
    assert running.returncode == 128 + number, rest
    assert b"Traceback" not in rest
    assert not list((tmp_path / "copies").iterdir())
    assert not list((tmp_path / "out").iterdir())


@rows("size, job", paired([1e32, 1e154, 1e300], [al.deviation, al.spectrum, al.identify, al.analyze]))
def test_what_no_sensor_gives_is_refused_in_words(job, size):
    values = np.random.default_rng(1).standard_normal(2000)
    for scale, words in ((size, "too large for any sensor"), (1 / size, "less than can be computed with")):
        with pytest.raises(al.DataError, match=words):
            job(al.Record(values * scale, rate=100.0, unit="rad/s"))
