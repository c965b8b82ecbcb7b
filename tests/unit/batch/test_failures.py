"""What breaks a batch, really: its process is killed, its disk is full, another run is at the same folder."""

import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from pyarrow import parquet
from tests.rows import rows

import allanite as al
from allanite.batch.job import run_batch
from allanite.batch.store import Store

COUNT = 8


@pytest.fixture(scope="module")
def units(tmp_path_factory):
    """Recordings, one of which is none."""
    folder = tmp_path_factory.mktemp("units")
    for i in range(COUNT - 1):
        record = al.simulate(al.N(0.1 + 0.02 * i, "deg/sqrt(h)"), 2000, 10.0, rng=i, name="gz")
        al.write(record, folder / f"u{i}.csv")
    (folder / "bad.csv").write_text("hello\nworld\n")
    return folder


@pytest.fixture(scope="module")
def plain(units, tmp_path_factory):
    """The results of a run that nothing disturbs."""
    results = tmp_path_factory.mktemp("results") / "plain"
    run_batch(units, results)
    return results


def contents(results):
    return {path.relative_to(results): path.read_bytes() for path in results.rglob("*") if path.is_file()}


def parts(results):
    return len(list(results.glob("parts/*.parquet")))


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


def command(units, results, program=("-m", "allanite.cli"), **choices):
    words = [sys.executable, *program, "batch", str(units), "--out", str(results), "--workers", "1"]
    return subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, **choices)


def resumed(units, results):
    """What the next run does is what the one before has not done, and nothing else."""
    before = parts(results)
    assert 0 < before < COUNT
    found = run_batch(units, results)
    assert (found.before, found.analyzed) == (before, COUNT - before)
    assert [Path(file.file).name for file in found.failed] == ["bad.csv"]


@pytest.mark.slow("processes that are killed")
def test_a_batch_that_was_killed_goes_on_and_leaves_no_draft(units, plain, tmp_path):
    results = tmp_path / "r"
    killed = command(units, results, program=("-c", KILLED))
    killed.communicate()
    assert killed.returncode == -signal.SIGKILL
    assert parts(results) == 3
    drafts = [results / ".allanite-0123456789ab.part", results / "parts" / ".allanite-ba9876543210.part"]
    for draft in drafts:  # what it may have been writing
        draft.write_bytes(b"PAR1")
    resumed(units, results)
    assert contents(results) == contents(plain)


@pytest.mark.slow("takes more than half a second")
def test_a_batch_whose_disk_is_full_says_so_and_goes_on(units, plain, tmp_path):
    results = tmp_path / "r"
    sizes = {row["key"]: (plain / "parts" / f"{row['key']}.parquet").stat().st_size for row in stored(plain, "files")}
    most = max(list(sizes.values())[2:])  # of the first two both fit, or the test says so
    process = command(units, results, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most - 1, most)))
    _, told = process.communicate()
    assert process.returncode == 2
    assert "File too large); give another path" in told
    assert not list(results.rglob(".allanite-*"))
    resumed(units, results)
    assert contents(results) == contents(plain)


def stored(results, name):
    return parquet.read_table(results / f"{name}.parquet").to_pylist()


def test_two_runs_do_not_write_to_the_same_folder(units, tmp_path):
    with Store.opened(tmp_path / "r", new=True).alone(), pytest.raises(al.UsageError, match="another run writes its"):
        run_batch(units, tmp_path / "r")
    assert parts(tmp_path / "r") == 0


@pytest.mark.slow("libraries of others")
@rows("name", ["files", "coefficients", "curves", "findings"])
def test_duckdb_pandas_and_polars_open_the_tables(plain, name):
    duckdb, pd, pl = map(pytest.importorskip, ("duckdb", "pandas", "polars"))
    path = str(plain / f"{name}.parquet")
    ((count,),) = duckdb.sql(f"select count(*) from '{path}'").fetchall()  # noqa: S608 - our own path
    assert count == len(pd.read_parquet(path)) == pl.read_parquet(path).height > 0


@pytest.mark.slow("libraries of others")
def test_duckdb_answers_a_question_over_two_tables(plain):
    duckdb = pytest.importorskip("duckdb")
    (found,) = duckdb.sql(
        f"""select f.file, c.value from '{plain}/files.parquet' f join '{plain}/coefficients.parquet' c using (file)
        where c.symbol = 'N' and f.status = 'done' order by c.value desc limit 1"""  # noqa: S608 - our own path
    ).fetchall()
    assert Path(found[0]).name == f"u{COUNT - 2}.csv"
    assert found[1] == max(row["value"] for row in stored(plain, "coefficients") if row["symbol"] == "N")
