"""Many records: nothing is done twice, one bad file stops nothing, and how they are run does not change a byte."""

import errno
import multiprocessing
import os
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from tests.commands import run
from tests.rows import refused, rows

import allanite as al
from allanite.batch import job, store
from allanite.batch.executor import Processes, Serial
from allanite.batch.job import run_batch
from allanite.batch.sources import manifest_of


@pytest.fixture(scope="module")
def units(tmp_path_factory):
    """Six recordings, one that is none, and a copy of one by another name."""
    folder = tmp_path_factory.mktemp("units")
    for i in range(6):
        noise = al.N(0.1 + 0.02 * i, "deg/sqrt(h)")
        al.write(al.simulate(noise, 2000, 10.0, rng=np.random.default_rng(i), name="gz"), folder / f"u{i}.csv")
    (folder / "bad.csv").write_text("hello\nworld\n")
    shutil.copy(folder / "u0.csv", folder / "v0.csv")
    return folder


@pytest.fixture(scope="module")
def serial(units, tmp_path_factory):
    """The results of one process."""
    results = tmp_path_factory.mktemp("results") / "serial"
    return run_batch(units, results), results


def contents(results):
    return {path.relative_to(results): path.read_bytes() for path in results.rglob("*") if path.is_file()}


def stored(results, name):
    return parquet.read_table(results / f"{name}.parquet").to_pylist()


def counted(monkeypatch, *, until=10**9):
    """The files that are analyzed from here on; the run is interrupted after some of them."""
    seen, real = [], job.analyze_plainly

    def task(item):
        if len(seen) == until:
            raise KeyboardInterrupt
        seen.append(Path(item["file"]).name)
        return real(item)

    monkeypatch.setattr(job, "analyze_plainly", task)
    return seen


@pytest.mark.slow("takes more than half a second")
def test_one_bad_file_is_named_and_the_others_have_their_rows(units, serial):
    found, results = serial
    assert [(Path(f.file).name, f.error[:30]) for f in found.failed] == [("bad.csv", "no rows of numbers were found ")]
    assert (found.analyzed, found.before) == (7, 0)  # of two with the same content, one
    status = {Path(row["file"]).name: row["status"] for row in stored(results, "files")}
    assert status == {"bad.csv": "failed"} | {f"u{i}.csv": "done" for i in range(6)} | {"v0.csv": "done"}
    studies = {f"u{i}.csv": al.analyze(units / f"u{i}.csv") for i in range(2)}
    for name, study in studies.items():
        (channel,) = study
        of = {row["symbol"]: row for row in stored(results, "coefficients") if Path(row["file"]).name == name}
        for e in channel.fit:
            assert (of[e.symbol]["value"], of[e.symbol]["upper"], of[e.symbol]["status"]) == (
                e.value, e.upper, e.status,
            )  # fmt: skip
            assert (of[e.symbol]["low"], of[e.symbol]["high"]) == e.interval()
        curve = [row for row in stored(results, "curves") if Path(row["file"]).name == name]
        assert [row["deviation"] for row in curve] == list(channel.curve.deviation)
        names = [row["name"] for row in stored(results, "findings") if Path(row["file"]).name == name]
        assert names == list(channel.quality.names)


@pytest.mark.slow("processes that are killed")
def test_processes_give_the_same_bytes_even_if_one_is_killed(units, serial, tmp_path):
    killed = []

    def kill_one(what, fraction):
        if fraction and not killed:
            killed.append(multiprocessing.active_children()[0])
            killed[0].kill()

    found = run_batch(units, tmp_path / "r", executor=Processes(2), progress=kill_one)
    assert killed
    assert len(found.failed) == 1
    assert contents(tmp_path / "r") == contents(serial[1])


@pytest.mark.slow("takes more than half a second")
def test_an_interrupted_batch_does_what_is_missing(units, serial, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        first = counted(patch, until=3)
        with pytest.raises(KeyboardInterrupt):
            run_batch(units, tmp_path / "r")
    status = [row["status"] for row in stored(tmp_path / "r", "files")]
    assert status == ["open"] * 8
    second = counted(monkeypatch)
    found = run_batch(units, tmp_path / "r")
    assert (len(first), len(second), found.before) == (3, 4, 4)  # u0.csv and its copy, u1.csv, bad.csv
    assert sorted(first + second) == ["bad.csv", *(f"u{i}.csv" for i in range(6))]
    assert contents(tmp_path / "r") == contents(serial[1])
    assert run_batch(units, tmp_path / "r").analyzed == 0
    assert second == second[:4]


@pytest.mark.slow("takes more than half a second")
def test_what_changed_is_done_again(units, serial, tmp_path, monkeypatch):
    results, own = tmp_path / "r", tmp_path / "own"
    shutil.copytree(serial[1], results)
    shutil.copytree(units, own)
    seen = counted(monkeypatch)
    assert run_batch(own, results).analyzed == 0  # another folder, the same content
    shutil.copy(own / "u1.csv", own / "u2.csv")
    (own / "bad.csv").unlink()
    damaged = store.Store.opened(results).part(stored(results, "files")[-2]["key"])
    damaged.write_bytes(damaged.read_bytes()[:1000])
    found = run_batch(own, results)
    assert seen == ["u5.csv"]
    assert not found.failed
    run_batch(own, results, al.Recipe(terms="N", method="gls"))
    assert len(seen) == 6


@pytest.mark.slow("seconds of analyses")
@rows("content", [None, "{"])
def test_a_part_whose_content_is_not_what_was_stored_is_done_again(serial, units, tmp_path, monkeypatch, content):
    results = tmp_path / "r"
    shutil.copytree(serial[1], results)
    part = store.Store.opened(results).part(stored(results, "files")[-2]["key"])
    table = parquet.read_table(part)
    at = table.column_names.index("study")
    changed = table.set_column(at, "study", pa.array([content]))
    parquet.write_table(changed.replace_schema_metadata(table.schema.metadata), part)
    seen = counted(monkeypatch)
    found = run_batch(units, results)
    assert (found.analyzed, len(seen)) == (1, 1)
    assert [note for note in found.notes if "is damaged" in note and seen[0] in note]
    assert contents(results) == contents(serial[1])


FOREIGN = {
    "other columns": lambda table: pa.table({"x": [1]}),
    "no description": lambda table: table.replace_schema_metadata(None),
    "no file": lambda table: table.slice(0, 0),
    "text for numbers": lambda table: table.append_column("temperature", pa.array(["warm"] * len(table))),
    "text for times": lambda table: table.append_column("date", pa.array(["today"] * len(table))),
    **{
        f"recipe {text[:9]}": lambda table, text=text: table.replace_schema_metadata({"allanite": "0", "recipe": text})
        for text in ("{", "5", "null", '{"level": "x"}', "[" * 100_000)
    },
}


@rows("name", FOREIGN)
def test_a_lot_of_a_foreign_table_is_refused(serial, tmp_path, name):
    table = parquet.read_table(serial[1] / "files.parquet")
    parquet.write_table(FOREIGN[name](table), tmp_path / "files.parquet")
    with pytest.raises(al.DataError, match=r"files.parquet' cannot be read .it is not the table of a batch"):
        al.batch.read_lot(tmp_path)


def test_a_failure_that_another_run_may_not_have_is_not_kept(units, tmp_path, monkeypatch):
    entry = tmp_path / "list.txt"
    entry.write_text(f"{units / 'u0.csv'}\n")
    with monkeypatch.context() as patch:
        patch.setattr(job, "analyze_plainly", lambda item: {"error": "needs h5py", "usage": True,
                                                               "allanite": al.__version__})  # fmt: skip
        refused(al.UsageError, "needs h5py", lambda: run_batch(entry, tmp_path / "r"))
    with monkeypatch.context() as patch:
        patch.setattr(job, "analyze_plainly", lambda item: {"study": {}, "allanite": "0.0.1"})
        assert "by version 0.0.1" in run_batch(entry, tmp_path / "r").failed[0].error
    assert not run_batch(entry, tmp_path / "r").failed


@pytest.mark.slow("takes more than half a second")
def test_a_full_disk_ends_the_batch_in_words_and_keeps_what_is_stored(units, tmp_path, monkeypatch):
    real, calls = os.fsync, []

    def full(number):
        calls.append(number)
        if len(calls) == 4:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(number)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        refused(al.UsageError, "No space left on device", lambda: run_batch(units, tmp_path / "r"))
    assert (len(list((tmp_path / "r" / "parts").iterdir())), run_batch(units, tmp_path / "r").analyzed) == (2, 5)


def test_a_manifest_lists_files_and_what_is_known_of_them(units, tmp_path):
    path = tmp_path / "m.csv"
    path.write_text(
        "file,unit_id,temperature,date,lab\n"
        f"{units}/u1.csv,SN1,25.5,2024-05-31T12:00+02:00,A\n"
        f"{units}/u0.csv,SN0,,2024-05-31,\n"
        "missing.csv,SN9,20,,B\n"
    )
    found = run_batch(path, tmp_path / "r", executor=Serial())
    assert [f.error for f in found.failed] == ["no such file; check the name and the folder"]
    got = {row["unit_id"]: row for row in stored(tmp_path / "r", "files")}
    assert (got["SN1"]["temperature"], got["SN1"]["date"].isoformat(), got["SN1"]["lab"]) == (
        25.5, "2024-05-31T10:00:00", "A",
    )  # fmt: skip
    assert (got["SN0"]["temperature"], got["SN0"]["lab"], got["SN9"]["status"]) == (None, None, "failed")


@rows(("name", "text", "words"), [
    ("m.csv", "path,unit_id\na.csv,1\n", "has no column 'file' but"),
    ("m.csv", "file,temperature\na.csv,warm\n", "line 2: the temperature is a number, not 'warm'"),
    ("m.csv", "file,date\na.csv,31.5.24\n", "line 2: the date is written as 2024-05-31"),
    (
        "m.csv",
        "file,date\na.csv,9999-12-31T23:59:59-23:59\n",
        "line 2: the date '9999.* is outside the years 1 to 9999",
    ),
    ("m.csv", f"file,lab\na.csv,{'x' * 200_000}\n", "line 2: field larger than field limit"),
    ("m.csv", f"file,date\na.csv,{'x' * 100_000}\n", r"line 2: the date .{20,300}$"),
    ("m.csv", 'file,lab\na.csv,"B\nb.csv,C\n', "line 2: unexpected end of data; is a quotation mark missing"),
    ("m.csv", "file,sha256\na.csv,1\n", r"columns named \['sha256'\]"),
    ("m.csv", "file,lab\na.csv\n", "line 2: 1 cells, expected 2"),
    ("m.csv", "file,lab\n,B\n", "line 2: no file is given"),
    ("m.csv", "file\na.csv\n./a.csv\n", "line 3: .*a.csv' is listed twice"),
    ("m.txt", "# nothing\n\n", "lists no file"),
])  # fmt: skip
def test_a_wrong_manifest_is_refused_by_line(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    refused(al.UsageError, words, lambda: manifest_of(tmp_path / name))


def test_a_folder_of_something_else_is_left_alone(units, tmp_path):
    (tmp_path / "thesis.tex").write_text("x")
    refused(al.UsageError, "does not hold the results of a batch", lambda: run_batch(units, tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def batch(*words):
    return run("batch", *words, "--workers", "1")


def test_the_verb_names_what_failed(units, serial, tmp_path):
    shutil.copytree(serial[1], tmp_path / "r")
    done = batch(units, "--out", tmp_path / "r")
    assert done.exit_code == 5
    assert "8 files: 0 analyzed now, 8 done before, 1 failed" in done.stdout
    assert f"{units / 'bad.csv'}: no rows of numbers" in done.stderr
    (tmp_path / "bad.txt").write_text(str(units / "bad.csv"))
    assert batch(tmp_path / "bad.txt", "--out", tmp_path / "r").exit_code == 3


def test_workers_and_a_scheduler_exclude_each_other(units, tmp_path):
    done = batch(units, "--out", tmp_path / "r", "--scheduler", "tcp://127.0.0.1:9")
    assert done.exit_code == 2
    assert "give one of them" in done.stderr
    # an option that fits no file is a wrong usage
    (tmp_path / "one.txt").write_text(str(units / "u0.csv"))
    done = batch(tmp_path / "one.txt", "--out", tmp_path / "r", "--method", "guess")
    assert done.exit_code == 2
    assert "guess" in done.stderr


@pytest.mark.slow("takes more than half a second")
def test_what_is_stored_does_not_depend_on_who_started_it(units, tmp_path):
    values = np.random.default_rng(0).standard_normal(4000)
    values[[500, 1500]] = 60
    al.write(al.Record(values, 10.0, "deg/h", name="gz"), tmp_path / "spikes.csv")
    (tmp_path / "one.txt").write_text("spikes.csv\n")
    run_batch(tmp_path / "one.txt", tmp_path / "python")
    assert batch(tmp_path / "one.txt", "--out", tmp_path / "command").exit_code == 0
    assert contents(tmp_path / "python") == contents(tmp_path / "command")
    assert any("--outliers" in row["remedy"] for row in stored(tmp_path / "python", "findings"))
