"""Many records: nothing is done twice, one bad file stops nothing, and how they are run does not change a byte.

What breaks a batch, really: its process is killed, its disk is full, another run is at the same folder.
"""

import multiprocessing
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from tests.commands import ends, run
from tests.rows import refused, rows
from tests.unit.batch.tasks import contents, stored, with_bad

import allanite as al
from allanite.batch import job, store
from allanite.batch.executor import Processes, Serial
from allanite.batch.job import run_batch
from allanite.batch.sources import manifest_of


@pytest.fixture(scope="module")
def units(tmp_path_factory):
    """Six recordings, one that is none, and a copy of one by another name."""
    folder = with_bad(tmp_path_factory.mktemp("units"), 0.1 + 0.02 * np.arange(6))
    shutil.copy(folder / "u0.csv", folder / "v0.csv")
    return folder


@pytest.fixture(scope="module")
def serial(units, tmp_path_factory):
    """The results of one process."""
    results = tmp_path_factory.mktemp("results") / "serial"
    return run_batch(units, results), results


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
    for name in ("u0.csv", "u1.csv"):
        (channel,) = al.analyze(units / name)
        coefficients, curve, findings = (
            [row for row in stored(results, table) if Path(row["file"]).name == name]
            for table in ("coefficients", "curves", "findings")
        )
        of = {row["symbol"]: [row[key] for key in ("value", "upper", "status", "low", "high")] for row in coefficients}
        for e in channel.fit:
            assert of[e.symbol] == [e.value, e.upper, e.status, *e.interval()]
        assert [row["deviation"] for row in curve] == list(channel.curve.deviation)
        assert [row["name"] for row in findings] == list(channel.quality.names)


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
    assert [row["status"] for row in stored(tmp_path / "r", "files")] == ["open"] * 8
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


def test_a_manifest_lists_files_and_what_is_known_of_them(units, tmp_path):
    (tmp_path / "m.csv").write_text(
        f"file,unit_id,temperature,date,lab\n{units}/u1.csv,SN1,25.5,2024-05-31T12:00+02:00,A\n"
        f"{units}/u0.csv,SN0,,2024-05-31,\nmissing.csv,SN9,20,,B\n"
    )
    found = run_batch(tmp_path / "m.csv", tmp_path / "r", executor=Serial())
    assert [f.error for f in found.failed] == ["no such file; check the name and the folder"]
    SN0, SN1, SN9 = sorted(stored(tmp_path / "r", "files"), key=lambda row: row["unit_id"])
    assert (SN1["temperature"], SN1["date"].isoformat(), SN1["lab"]) == (25.5, "2024-05-31T10:00:00", "A")
    assert (SN0["temperature"], SN0["lab"], SN9["status"]) == (None, None, "failed")


@rows(("name", "text", "words"), [
    ("m.csv", "path,unit_id\na.csv,1\n", "has no column 'file' but"),
    ("m.csv", "file,temperature\na.csv,warm\n", "line 2: the temperature is a number, not 'warm'"),
    ("m.csv", "file,date\na.csv,31.5.24\n", "line 2: the date is written as 2024-05-31"),
    ("m.csv", "file,date\na.csv,9999-12-31T23:59:59-23:59\n", "line 2: the date '9999.* is outside the years 1 to 99"),
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
    ends(done, 5, f"{units / 'bad.csv'}: no rows of numbers")
    assert "8 files: 0 analyzed now, 8 done before, 1 failed" in done.stdout
    (tmp_path / "bad.txt").write_text(str(units / "bad.csv"))
    assert batch(tmp_path / "bad.txt", "--out", tmp_path / "r").exit_code == 3
    ends(batch(units, "--out", tmp_path / "r", "--scheduler", "tcp://127.0.0.1:9"), 2, "give one of them")
    # an option that fits no file is a wrong usage
    (tmp_path / "one.txt").write_text(str(units / "u0.csv"))
    ends(batch(tmp_path / "one.txt", "--out", tmp_path / "r", "--method", "guess"), 2, "guess")


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


KILLED = """
import os, signal
from allanite.batch.store import Store
from allanite.cli import main
put = Store.put

def third(store, key, result):
    put(store, key, result)
    if len(list(store.folder.glob("parts/*.parquet"))) == 3:
        os.kill(os.getpid(), signal.SIGKILL)

Store.put = third
main()
"""


def ended(units, results, program=("-m", "allanite.cli"), **choices):
    """The exit code and the last words of a batch in a process of its own."""
    words = [sys.executable, *program, "batch", units, "--out", results, "--workers", "1"]
    done = subprocess.run(words, capture_output=True, text=True, check=False, **choices)
    return done.returncode, done.stderr


def resumed(units, results, expected):
    """What the next run does is what the one before has not done, and nothing else."""
    before = len(list(results.glob("parts/*.parquet")))
    assert 0 < before < 7
    found = run_batch(units, results)
    assert (found.before, found.analyzed) == (before + 1, 7 - before)  # u0.csv and its copy have one part
    assert [Path(file.file).name for file in found.failed] == ["bad.csv"]
    assert contents(results) == contents(expected)


@pytest.mark.slow("processes that are killed")
def test_a_batch_that_was_killed_goes_on_and_leaves_no_draft(units, serial, tmp_path):
    results = tmp_path / "r"
    assert ended(units, results, ("-c", KILLED))[0] == -signal.SIGKILL
    for draft in (results / ".allanite-0123456789ab.part", results / "parts" / ".allanite-ba9876543210.part"):
        draft.write_bytes(b"PAR1")  # what it may have been writing
    resumed(units, results, serial[1])


@pytest.mark.slow("takes more than half a second")
def test_a_batch_whose_disk_is_full_says_so_and_goes_on(units, serial, tmp_path):
    keys = dict.fromkeys(row["key"] for row in stored(serial[1], "files"))
    sizes = [store.Store.opened(serial[1]).part(key).stat().st_size for key in keys]
    limits = max(sizes[2:]) - 1, max(sizes[2:])  # of the first two both fit, or the test says so
    limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limits)}
    code, told = ended(units, tmp_path / "r", **limited)
    assert code == 2
    assert "File too large); give another path" in told
    assert not list((tmp_path / "r").rglob(".allanite-*"))
    resumed(units, tmp_path / "r", serial[1])


def test_two_runs_do_not_write_to_the_same_folder(units, tmp_path):
    with store.Store.opened(tmp_path / "r", new=True).alone():
        refused(al.UsageError, "another run writes its", lambda: run_batch(units, tmp_path / "r"))
    assert not list((tmp_path / "r" / "parts").iterdir())


@pytest.mark.slow("libraries of others")
def test_duckdb_pandas_and_polars_open_the_tables(serial):
    duckdb, pd, pl = map(pytest.importorskip, ("duckdb", "pandas", "polars"))
    for name in ("files", "coefficients", "curves", "findings"):
        path = str(serial[1] / f"{name}.parquet")
        ((count,),) = duckdb.sql(f"select count(*) from '{path}'").fetchall()  # noqa: S608 - our own path
        assert count == len(pd.read_parquet(path)) == pl.read_parquet(path).height > 0
    (largest,) = duckdb.sql(
        f"""select f.file, c.value from '{serial[1]}/files.parquet' f join '{serial[1]}/coefficients.parquet' c
        using (file) where c.symbol = 'N' and f.status = 'done' order by c.value desc limit 1"""  # noqa: S608
    ).fetchall()
    assert Path(largest[0]).name == "u5.csv"
    assert largest[1] == max(row["value"] for row in stored(serial[1], "coefficients") if row["symbol"] == "N")
