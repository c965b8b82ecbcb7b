"""The folder of the page: states of other versions, what stands in the way, a full disk, and how much is kept."""

import errno
import json
import os
from concurrent.futures import Future

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.web import worker
from allanite.web.jobs import Jobs
from allanite.web.schema import JobBody, plain
from allanite.web.server import application
from allanite.web.store import FullError, Store
from allanite.web.worker import MAX_RESULTS, Held

from .served import Told, answered

MB = 1_000_000


class Lanes:
    """Workers that answer at once: each task with what a function makes of it."""

    def __init__(self, answer):
        self.ask = answer
        self.lanes = []

    def submit(self, lane, work):
        self.lanes.append(lane)
        future = Future()
        try:
            future.set_result(work(self))
        except BaseException as error:
            future.set_exception(error)
        return future

    def end(self, lane):
        pass


def asked(store, jobs, method, path, **body):
    """The answer of the page to a request."""
    return answered(application(store, jobs, {"lang": "en", "workspace": None}), method, path, json=body)


RESULT = {"json": "{}", "faces": {}, "exit": 0}


def opened(folder, answer=lambda *_: RESULT, **sizes):
    """A store with a workspace and a file that is opened where it is, and its jobs."""
    store = Store(folder / "store", **{"limit": MB, "quota": MB} | sizes)
    jobs = Jobs(store)
    jobs.workers = Lanes(answer)
    name, path = store.new()["id"], folder / "g.csv"
    path.write_text("gx [deg/h]\n1\n2\n")
    file = {"id": f"{name}-{'1' * 16}", "name": "g.csv", "bytes": 9, "path": str(path), "own": False}
    store.add(file)
    return store, jobs, name, file


def state_of(store, name):
    return store.folder / name / "state.json"


def test_what_another_version_has_written_stays(tmp_path):
    store, jobs, name, file = opened(tmp_path)
    job = jobs.begin(name, JobBody(verb="info", files=[file["id"]], recipe={"rate": 10}))
    path = state_of(store, name)
    data = json.loads(path.read_text())
    newer = {"of a newer version": [1, {"a": None}]}
    data |= newer
    data["jobs"][job["id"]] |= newer | {"problem": {"error": "x", "option": None, "exit": 2} | newer}
    data["files"][file["id"]] |= newer
    path.write_text(json.dumps(data))
    store = Store(store.folder, limit=MB, quota=MB)
    store.clear()
    with store.changed(name) as state:
        state["choices"] = {"seen": True}
    assert json.loads(path.read_text()) == data | {"choices": {"seen": True}}
    assert store.notes == store.aside() == []


OTHER = f"{'0' * 16}-{'1' * 16}"
CHANGED = {
    "a state that is unknown": lambda data: next(iter(data["jobs"].values())).update(state="paused"),
    "a key that is missing": lambda data: data.pop("choices"), "another type": lambda data: data.update(files=[]),
    "another id": lambda data: data.update(id="0" * 16), "no jobs": lambda data: data.pop("jobs"),
    "a foreign file": lambda data: data["files"].update({"../x": {"id": "../x"}}),
    "a file of another": lambda data: data["files"].update({OTHER: next(iter(data["files"].values())) | {"id": OTHER}}),
}  # fmt: skip
DAMAGED = {
    "empty": lambda whole: b"", "cut": lambda whole: whole[:-20], "list": lambda whole: b"[]",
    "NaN": lambda whole: whole.replace(b"{}", b'{"a":NaN}', 1), "binary": lambda whole: os.urandom(300),
    "surrogate": lambda whole: whole.replace(b"{}", rb'{"a":"\ud800"}', 1),
    "deep": lambda whole: whole.replace(b"{}", b"[" * 9000, 1),
}  # fmt: skip


@rows("how", [*CHANGED, *DAMAGED])
def test_work_of_another_version_is_named_offered_for_deletion_and_read_again_by_its_own(tmp_path, how):
    store, jobs, name, file = opened(tmp_path)
    jobs.begin(name, JobBody(verb="info", files=[file["id"]], recipe={"rate": 10}))
    path = state_of(store, name)
    sound, foreign = path.read_bytes(), store.folder / "my notes"
    data = json.loads(sound)
    CHANGED.get(how, len)(data)
    path.write_bytes(DAMAGED.get(how, bytes)(json.dumps(data).encode()))
    foreign.mkdir()
    (foreign / "state.json").touch()
    for _ in range(3):
        store = Store(store.folder, limit=MB, quota=MB)
        store.clear()
        assert store.all() == []
        ((aside,), (note,)) = store.aside(), store.notes
        assert "is damaged, or of another version of allanite" in note
        assert aside["bytes"] == MB - store.room()
        assert path.with_name("state.json.damaged").is_file()
    path.with_name("state.json.damaged").write_bytes(sound)
    store = Store(store.folder, limit=MB, quota=MB)
    store.clear()
    assert (store.find(name), store.aside(), store.notes) == (json.loads(sound), [], [])
    assert (foreign / "state.json").is_file()


def stand(place, how):
    """Put something in the way of a workspace."""
    path = place / "state.json"
    if how == "a draft that is a folder":
        (place / ".allanite-0.part").mkdir()
        return
    if how == "a link to a workspace":
        place.rename(place.parent / "elsewhere")
        place.symlink_to(place.parent / "elsewhere")
        return
    path.unlink()
    {"a folder": path.mkdir, "a pipe": lambda: os.mkfifo(path), "nothing": lambda: None,
     "a dangling link": lambda: path.symlink_to("nowhere"), "a loop": lambda: path.symlink_to(path.name),
     "a folder that cannot be renamed": path.mkdir}[how]()  # fmt: skip
    if "renamed" in how:
        (place / "state.json.damaged" / "x").mkdir(parents=True)


@rows("how", ["a folder", "a pipe", "nothing", "a dangling link", "a loop", "a folder that cannot be renamed",
              "a draft that is a folder", "a link to a workspace"])  # fmt: skip
def test_whatever_is_in_the_place_of_a_state_the_rest_is_served_and_it_can_be_deleted(tmp_path, how):
    store, _, name, _ = opened(tmp_path)
    other = store.new()["id"]
    stand(store.folder / name, how)
    for _ in range(2):
        store = Store(store.folder, limit=MB, quota=MB)
        store.clear()
        for _ in range(2):
            assert other in [state["id"] for state in store.all()]
            assert {one["id"] for one in store.aside()} <= {name}
        assert len(store.notes) <= 1
    for method, path in (("GET", "workspaces"), ("GET", "tables"), ("DELETE", f"workspaces/{name}")):
        assert asked(store, Jobs(store), method, f"/api/{path}").status_code == 200
    assert not os.path.lexists(store.folder / name)
    assert [state["id"] for state in store.all()] == [other]
    assert store.aside() == []


@pytest.fixture
def full(monkeypatch):
    """Makes the disk full, or gives it room."""
    fsync = os.fsync

    def make(yes):
        def refuse(_):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr(os, "fsync", refuse if yes else fsync)

    return make


def test_on_a_full_disk_nothing_is_entered_and_jobs_end(tmp_path, full):
    store, jobs, name, file = opened(tmp_path)
    before = state_of(store, name).read_bytes()
    begin = lambda: jobs.begin(name, JobBody(verb="info", files=[file["id"]], recipe={"rate": 10}))  # noqa: E731
    full(True)
    for act in (store.new, lambda: store.add(file | {"id": f"{name}-{'2' * 16}"}), begin, lambda: upload(store, name)):
        with pytest.raises(FullError, match="make room on the disk") as refused:
            act()
        assert "give another path" not in str(refused.value)
    assert state_of(store, name).read_bytes() == before
    assert json.loads(before) == store.state(name)
    assert len(list(store.folder.iterdir())) == 1
    assert {path.name for path in (store.folder / name).iterdir()} == {"state.json"}
    # what is computed while the disk becomes full
    full(False)
    jobs.workers.ask = lambda task, arguments, tell, ended: full(True) or tell("progress", {}) or RESULT
    job = begin()
    last = jobs.live[job["id"]].events[-1]
    assert (last[1], job["state"]) == ("failed", "failed")
    assert "make room on the disk" in last[2]["error"]
    full(False)
    jobs.workers.ask = lambda *_: RESULT
    assert begin()["state"] == "done"


def upload(store, name):
    with store.arriving(name, "a.csv") as (_, path):
        path.write_bytes(b"1")


def test_a_trace_that_cannot_be_stored_loses_no_analysis(tmp_path, monkeypatch):
    held, path = Held(Told()), tmp_path / "g.npy"
    np.save(path, np.zeros(100))
    held.room, held.quota, held.files = MB, MB, {str(path): ("id", str(tmp_path), "g.npy")}

    def save(*_):
        raise OSError("100 requested and 7 written")

    monkeypatch.setattr(np, "save", save)
    assert held.source(str(path), al.Recipe(rate=100, unit="deg/s"))[0].size == 100
    (problem,) = held.connection.problems
    assert problem["error"] == "the trace cannot be stored (100 requested and 7 written); make room on the disk"
    assert [one.name for one in tmp_path.iterdir()] == ["g.npy"]


def test_traces_of_several_workspaces_at_once_stay_within_the_quota(tmp_path):
    def answer(task, arguments, tell, ended):
        ((file, folder, _),) = arguments["kept"][0].values()
        os.makedirs(f"{folder}/trace")
        with open(f"{folder}/trace/0.0.npy", "wb") as out:
            out.write(b"1" * 8000)
        tell("trace", {"file": file, "problem": None})
        return RESULT

    store, jobs, name, file = opened(tmp_path, answer, quota=5000)
    job = jobs.begin(name, JobBody(verb="info", files=[file["id"]], recipe={"rate": 10}))
    told = [data for _, kind, data in jobs.live[job["id"]].events if kind == "trace"]
    assert told[0]["problem"]["option"] == "quota"
    assert job["state"] == "done"
    assert not list(store.folder.rglob("trace"))


def test_results_in_memory_are_few_and_the_newest(tmp_path):
    held, path = Held(Told()), tmp_path / "g.csv"
    path.write_text("gx [deg/h]\n" + "1\n2\n4\n" * 20)
    for k in range(MAX_RESULTS + 3):
        held.drawn[str(k), "gx", "oadev"] = None
        worker.run(held, str(k), verb="info", paths=[str(path)], choices={"rate": 10}, shown="", lang="en",
                   kept=({}, MB, MB))  # fmt: skip
    assert list(held.values) == [str(k) for k in range(3, MAX_RESULTS + 3)]
    assert {key[0] for key in held.drawn} == set(held.values)


@rows("deep", [40, 51, 150, 210, 5000])
def test_json_is_refused_by_its_depth(deep):
    for begin, end in ((b"[", b"]"), (b'{"a":', b"}")):
        data = begin * deep + b"1" + end * deep
        if deep < 50:
            assert plain(data)
        else:
            with pytest.raises(al.UsageError, match=r"^lists and objects are nested more than 50 deep$"):
                plain(data)


@rows(("sizes", "words"), [({"quota": 5000}, "delete some of them, or allow more with"), ({"limit": 10}, "")])
def test_an_example_is_no_upload(tmp_path, sizes, words):
    """It has no path by which it could be opened, and no limit but the quota."""
    store, jobs, name, _ = opened(tmp_path, **sizes)

    def answer(task, arguments):
        with open(arguments["line"][1], "wb") as out:
            out.write(b"1" * 6000)
        return {}

    jobs.workers.ask = answer
    answered = asked(store, jobs, "POST", f"/api/workspaces/{name}/example", name="mems")
    assert answered.status_code == (413 if words else 200)
    assert words in answered.text
    assert "by its path" not in answered.text


def test_a_folder_that_is_gone_is_named(tmp_path):
    store, jobs, name, file = opened(tmp_path)
    store.folder.rename(tmp_path / "away")
    for method, path in (("GET", "/api/workspaces"), ("POST", "/api/workspaces"), ("GET", "/api/tables"),
                         ("POST", f"/api/workspaces/{name}/files?name=a"), ("PUT", f"/api/workspaces/{name}/choices"),
                         ("DELETE", f"/api/workspaces/{name}/files/{file['id']}")):  # fmt: skip
        answer = asked(store, jobs, method, path)
        assert answer.status_code in (400, 413), (path, answer.text)
        assert str(store.folder) in answer.json()["error"]
        assert "internal error" not in answer.text


def test_a_file_that_is_opened_by_its_path_stays_where_it_is(tmp_path):
    store, jobs, name, file = opened(tmp_path)
    jobs.begin(name, JobBody(verb="info", files=[file["id"]], recipe={"rate": 10}))
    assert not [path for path in store.folder.rglob("*") if path.name.startswith("data")]
    store.drop(file["id"])
    with pytest.raises(al.AllaniteError, match="there is no file"):
        store.file(file["id"])
    assert (tmp_path / "g.csv").read_text() == "gx [deg/h]\n1\n2\n"
