"""What the page keeps: by one server, within its quota, read by schemas; and what many requests at once cannot stop."""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import rows

import allanite as al
from allanite.web.jobs import MAX_EVENTS, Live
from allanite.web.server import serve
from allanite.web.worker import Held

from .served import WAIT, Client, Told, served, waiting_job

MB = 1_000_000


@pytest.fixture(scope="module")
def link(folder):
    with served(folder, "--limit", "10MB", "--quota", "20MB", waiting=True) as (_, link):
        yield link


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "g.csv"
    np.savetxt(path, np.random.default_rng(1).normal(size=3000), header="gx [deg/h]", comments="", fmt="%.5g")
    return path


def kept(folder):
    return folder / "allanite" / "serve"


def pieces(megabytes, begun=lambda: None):
    """An upload in pieces; `begun` is called once the first one is sent."""
    yield b"1" * 100_000
    begun()
    for _ in range(10 * megabytes - 1):
        yield b"1" * 100_000


@pytest.mark.slow("takes more than half a second")
@rows("stated", [True, False], ids=["stated", "streamed"])
def test_uploads_side_by_side_stay_within_the_quota(client, folder, stated):
    workspace, together = client.workspace(), threading.Barrier(10)

    def upload(where, begun=lambda: None):
        with client.again() as one:
            content = b"1" * 9 * MB if stated else pieces(9, begun)
            return one.http.post(f"/api/workspaces/{where}/files", params={"name": "a.csv"}, content=content)

    with ThreadPoolExecutor(10) as pool:
        answers = list(pool.map(upload, [workspace] * 10, [together.wait] * 10))
    entered = [answer.json()["id"] for answer in answers if answer.status_code == 200]
    refused = [answer for answer in answers if answer.status_code != 200]
    assert {(answer.status_code, "allow more with --quota" in answer.text) for answer in refused} == {(413, True)}
    data = [path.stat().st_size for path in (kept(folder) / workspace).rglob("data*")]
    assert sum(data) <= 20 * MB
    assert len(data) == len(entered) <= 2
    for one in entered:  # which makes room
        client.http.delete(f"/api/workspaces/{workspace}/files/{one}")
    again = client.workspace()
    for _ in range(2):
        assert upload(again).status_code == 200
    for one in (workspace, again):
        client.http.delete(f"/api/workspaces/{one}")


@pytest.mark.slow("a server that is stopped, killed, or interrupted")
def test_what_an_upload_left_when_the_server_was_killed_is_removed(tmp_path):
    with served(tmp_path) as (process, link), Client(link) as client:
        workspace = client.workspace()
        sent, ended = threading.Event(), threading.Event()

        def endless():
            yield from pieces(5)
            sent.set()
            ended.wait(WAIT)

        def upload():
            with client.again() as one, pytest.raises(Exception, match=r".*"):
                one.http.post(f"/api/workspaces/{workspace}/files", params={"name": "a.csv"}, content=endless())

        threading.Thread(target=upload, daemon=True).start()
        assert sent.wait(WAIT)
        process.kill()
        process.wait()
        ended.set()
    assert list(kept(tmp_path).rglob("data.csv"))
    with served(tmp_path) as (_, link), Client(link) as client:
        assert client.get(f"/api/workspaces/{workspace}").json()["files"] == []
        assert not list(kept(tmp_path).rglob("data.csv"))


def test_the_quota_holds_for_the_trace_of_a_file_that_is_opened(tmp_path):
    held = Held(Told())
    held.room, held.quota, held.files = 300_000, 300_000, {}
    recipe = al.Recipe(rate=100, unit="deg/s")
    for size in (50_000, 100_000, 10_000):
        path, place = tmp_path / f"{size}.npy", tmp_path / f"trace of {size}"
        np.save(path, np.random.default_rng(2).normal(size=size))
        place.mkdir()
        held.files[str(path)] = ("id", str(place), path.name)
        assert held.source(str(path), recipe)[0].size == size
    assert [problem and problem["option"] for problem in held.connection.problems] == [None, "quota", None]
    assert sorted(path.parent.name for path in tmp_path.rglob("trace")) == ["trace of 10000", "trace of 50000"]
    taken = sum(path.stat().st_size for path in tmp_path.rglob("trace/*"))
    assert 240_000 < taken <= 300_000 - held.room + 4000


PARTS = ["value.json", "shown.json", "meta.json", "0.0.npy"]


@pytest.mark.slow("takes more than half a second")
@rows("part", PARTS)
def test_a_damaged_result_is_told_and_can_be_made_again(client, folder, file, part):
    workspace = client.workspace()
    uploaded = client.upload(workspace, file)
    job, last = client.run(workspace, "analyze", [uploaded], {"rate": 100})
    assert last[0] == "done"
    (path,) = (kept(folder) / workspace).rglob(f"*{part}")
    path.write_bytes(path.read_bytes()[:-400])
    answers = [client.get(f"/api/jobs/{job}"), client.get(f"/api/files/{uploaded}/trace")]
    assert sorted(answer.status_code for answer in answers) in ([200, 400], [200, 404])
    assert any("again" in answer.text or "no trace" in answer.text for answer in answers)
    job, last = client.run(workspace, "analyze", [uploaded], {"rate": 100})
    assert client.get(f"/api/jobs/{job}").status_code == client.get(f"/api/files/{uploaded}/trace").status_code == 200
    client.http.delete(f"/api/workspaces/{workspace}")


def second(folder, *arguments):
    command = [sys.executable, "-m", "allanite.cli", "serve", "--no-browser", *map(str, arguments)]
    environment = os.environ | {"XDG_CACHE_HOME": str(folder)}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.slow("takes more than half a second")
def test_a_second_server_joins_the_first(tmp_path, file):
    with served(tmp_path) as (process, link), Client(link) as client:
        said = second(tmp_path, "--port", client.base.rpartition(":")[2], file)
        assert (said.returncode, said.stderr) == (0, "")
        assert "a server of yours runs already" in said.stdout
        other, _, workspace = said.stdout.splitlines()[0].partition("&workspace=")
        with Client(other) as tab:
            assert tab.base == client.base
            assert [one["name"] for one in tab.get(f"/api/workspaces/{workspace}").json()["files"]] == ["g.csv"]
        missing = second(tmp_path, tmp_path / "none.csv")
        assert missing.returncode == 3
        assert "there is no file" in missing.stderr
        process.send_signal(signal.SIGSTOP)
        stopped = second(tmp_path)
        assert stopped.returncode == 2
        assert "does not answer; end it first" in stopped.stderr
        process.kill()  # the lock of a process that is dead is taken over
        process.wait()
    with served(tmp_path) as (_, link), Client(link) as client:
        assert client.get("/api/workspaces").status_code == 200


@pytest.mark.slow("a server that is stopped, killed, or interrupted")
def test_ctrl_c_ends_a_server_that_still_compiles(tmp_path, file, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    with served(tmp_path) as (process, link), Client(link) as client:
        workspace = client.workspace()
        job = client.begin(workspace, "analyze", [client.upload(workspace, file)], {"rate": 100})
        assert any(kind == "progress" and data["word"] == "preparing" for kind, data in client.events(job))
        process.send_signal(signal.SIGINT)
        assert process.wait(WAIT) == 130


@pytest.mark.slow("a server that is stopped, killed, or interrupted")
def test_a_job_is_begun_once_more_after_ctrl_c(tmp_path, file):
    """Whoever waits for the server is answered, and the terminal has one line, also after uploads that broke off."""
    with (
        served(tmp_path, waiting=True) as (process, link),
        Client(link) as client,
        waiting_job(client, tmp_path) as (workspace, job),
        ThreadPoolExecutor(2) as pool,
    ):
        place = f"/api/workspaces/{workspace}"
        example = pool.submit(client.again().post, f"{place}/example")
        while not any(path.is_dir() for path in (kept(tmp_path) / workspace).iterdir()):
            client.get("/api/workspaces")
        for how in ("?name=a.csv HTTP/1.1\r\nContent-Length: 9", " HTTP/1.1\r\nTransfer-Encoding: chunked"):
            host, _, port = client.base.removeprefix("http://").partition(":")
            own = f"Host: {host}:{port}\r\nOrigin: {client.base}\r\nAuthorization: Bearer {client.secret}\r\n\r\nZ"
            with socket.create_connection((host, int(port))) as one:
                one.sendall(f"POST {place}/files{how}\r\n{own}".encode())
        events = client.again().events(job)
        next(events)
        process.send_signal(signal.SIGINT)
        process.wait(WAIT)
        assert example.result().json()["error"].startswith("the server was ended")
        assert process.stderr.read() == "\nerror: interrupted\n"
    assert not list(kept(tmp_path).rglob("data*"))
    with served(tmp_path, waiting=True) as (_, link), Client(link) as client:
        assert client.get(f"/api/workspaces/{workspace}").json()["jobs"][0]["state"] in ("waiting", "running")
        client.post(f"/api/jobs/{job}/cancel")
        assert list(client.events(job))[-1][1]["error"] == "cancelled"


@pytest.mark.slow("a server that is stopped, killed, or interrupted")
@rows("stopped", [False, True])
def test_a_stream_has_its_results_when_the_server_ends(tmp_path, stopped):
    path = tmp_path / "growing.txt"
    path.write_text("gx [deg/h]\n" + "".join(f"{v:.4f}\n" for v in np.random.default_rng(2).normal(size=4000)))
    with served(tmp_path) as (process, link), Client(link) as client:
        workspace = client.workspace()
        job = client.begin(workspace, "watch", [], {"rate": 100, "every": 0.2}, target=str(path))
        assert any(kind == "live" for kind, _ in client.events(job))
        if stopped:  # what is coming to its end already is not asked twice, which would end it without results
            client.post(f"/api/jobs/{job}/cancel")
        process.send_signal(signal.SIGINT)
        process.wait(WAIT)
    with served(tmp_path) as (_, link), Client(link) as client:
        made = client.get(f"/api/jobs/{job}").json()
        assert made["state"] == "done", made["problem"]
        terms = made["value"]["channels"][0]["fit"]["terms"]
        assert {term["symbol"]: term["status"] for term in terms}["N"] == "identified"


def blocked(place, how):
    """What the page keeps its files in, with something in its way."""
    base = place / "allanite"
    if how in ("file", "link"):
        base.mkdir()
        (base / "serve").write_text("") if how == "file" else (base / "serve").symlink_to(place / "nowhere")
    elif how == "below a file":
        base.write_text("")
    else:
        (base / "serve").mkdir(parents=True)
        (base / "serve" / "address").mkdir() if how == "address" else os.mkfifo(base / "serve" / ".lock")


@rows("how", ["file", "link", "below a file", "address", "lock", "below /proc"])
def test_what_stands_in_the_way_is_named(tmp_path, monkeypatch, how):
    place = Path("/proc/self") if how == "below /proc" else tmp_path
    monkeypatch.setenv("XDG_CACHE_HOME", str(place))
    blocked(tmp_path, how)
    with pytest.raises(al.UsageError, match="cannot be used") as refused:
        serve([], port=0, browser=False, lang="en", limit=1, quota=1)
    assert str(place / "allanite") in str(refused.value)


def test_a_user_without_a_home_is_told(monkeypatch):
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    with pytest.raises(al.UsageError, match="set HOME"):
        serve([], port=0, browser=False, lang="en", limit=1, quota=1)


@rows(
    ("words", "code", "said"),
    [
        (["--limit", "0"], 2, "--limit is a size such as 1GB or 500MB, not '0'"),
        (["--quota", "-1GB"], 2, "--quota is a size such as 1GB or 500MB, not '-1GB'"),
        (["--quota", "9" * 400 + "GB"], 2, "--quota is a size such as"), (["--limit", ""], 2, "--limit is a size"),
        (["--port", "70000"], 2, "--port"), (["--lang", "xx"], 2, "unknown language 'xx'"),
        (["/"], 3, "'/' is a folder: give a file of it"), (["none"], 3, "no file 'none'"), ([""], 3, "no file ''"),
    ],
)  # fmt: skip
def test_options_are_refused_before_anything_is_kept(tmp_path, monkeypatch, words, code, said):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    ends(run("serve", "--no-browser", *words), code, said)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow("takes more than half a second")
def test_a_name_that_is_not_utf_8_is_refused_in_words(tmp_path):
    path = os.fsencode(tmp_path) + b"/gyro\xff.csv"
    with open(path, "wb") as out:
        out.write(b"gx [deg/h]\n1\n2\n")
    said = second(tmp_path, os.fsdecode(path))
    assert said.returncode == 3
    assert "is not UTF-8, which the page needs: rename the file" in said.stderr


@pytest.mark.slow("takes more than half a second")
def test_fifty_waiting_requests_stop_nothing(client, file, tmp_path):
    """What needs no worker is answered while 50 questions wait for one that is busy until it is cancelled."""
    workspace = client.workspace()
    done, _ = client.run(workspace, "analyze", [client.upload(workspace, file)], {"rate": 100})
    answers = []

    def ask():
        with client.again() as tab:
            answers.append(tab.get(f"/api/jobs/{done}/deviation", channel="gx", statistic="hdev").status_code)

    tabs = [threading.Thread(target=ask) for _ in range(50)]
    with waiting_job(client, tmp_path, workspace) as (_, job), client.again() as tab:
        for one in tabs:
            one.start()
        paths = ("/api/tables", "/api/workspaces", f"/api/jobs/{job}")
        assert [tab.get(path).status_code for path in paths] == [200] * len(paths)
        assert answers == []
        assert tab.post(f"/api/jobs/{job}/cancel").status_code == 200
    for one in tabs:
        one.join()
    assert answers == [200] * 50
    client.http.delete(f"/api/workspaces/{workspace}")


@pytest.mark.slow("takes more than half a second")
def test_cancelling_a_job_that_waits_leaves_the_one_before_it(client, file, tmp_path):
    with waiting_job(client, tmp_path) as (workspace, job):
        waiting = client.begin(workspace, "info", [client.upload(workspace, file)], {"rate": 100})
        client.post(f"/api/jobs/{waiting}/cancel")
        assert list(client.events(waiting))[-1] == ("failed", {"error": "cancelled", "option": None, "exit": 130})
        assert client.get(f"/api/jobs/{job}").json()["state"] == "running"
    assert list(client.events(job))[-1][0] == "done"
    client.http.delete(f"/api/workspaces/{workspace}")


def test_reports_of_a_long_job_are_bounded():
    live = Live()
    for i in range(10_000):
        live.tell(("progress", "words", "live")[i % 3], {"i": i})
    live.tell("done", {"exit": 0})
    numbers = [number for number, _, _ in live.events]
    assert len(numbers) <= MAX_EVENTS
    assert numbers == sorted(set(numbers))
    assert [kind for _, kind, _ in live.events].count("live") == 1
    assert live.events[-1] == (10_000, "done", {"exit": 0})


@pytest.mark.slow("takes more than half a second")
@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root can become another user")
def test_another_user_of_the_machine_gets_nothing():
    """By the port, by the folder, or with a secret of their own."""
    with tempfile.TemporaryDirectory() as place, served(place) as (_, link), Client(link) as client:
        os.chmod(place, 0o755)  # noqa: S103 - the folders below it are closed
        with Client(link, enter=False) as stranger:
            os.setegid(65534)
            os.seteuid(65534)
            try:
                for value in (f"Bearer {'x' * len(client.secret)}", "Bearer", ""):
                    answer = stranger.http.get("/api/workspaces", headers={"Authorization": value})
                    assert answer.status_code == 401
                for path in ("address", ".lock"):
                    with pytest.raises(PermissionError):
                        (kept(Path(place)) / path).stat()
                with pytest.raises(PermissionError):
                    os.listdir(kept(Path(place)))
            finally:
                os.seteuid(0)
                os.setegid(0)
