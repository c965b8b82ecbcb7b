"""Who may come in, and what hostile input cannot do."""

import http.client
import re
import socket
import stat
from contextlib import closing
from itertools import product

import numpy as np
import pytest
from tests.commands import run
from tests.hostile import generator, mutated, options_of
from tests.rows import rows
from tests.sound_files import SEEDS

from allanite.cli.front import EXCEEDED
from allanite.reporting.digits import printable
from allanite.web.server import MAX_LINK_AGE_S, MAX_LINKS, ROUTES, Door

from .served import Client, answered, served

LIMIT = 1_000_000


@pytest.fixture(scope="module")
def link(folder):
    with served(folder, "--limit", "1MB") as (_, link):
        yield link


def raw(client, path, host=None, method="GET"):
    """The status of a request as it is written, with the secret and no other header of its own."""
    own = client.base.removeprefix("http://")
    with closing(http.client.HTTPConnection(own, timeout=120)) as connection:
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        connection.putheader("Host", own if host is None else host)
        connection.putheader("Authorization", client.http.headers["Authorization"])
        connection.endheaders()
        return connection.getresponse().status


@pytest.mark.slow("takes more than half a second")
def test_it_listens_at_this_machine_alone(client):
    port = client.http.base_url.port
    with open("/proc/net/tcp", encoding="ascii") as file:
        rows = [line.split()[1] for line in file if line.split()[3] == "0A"]
    assert [row for row in rows if row.endswith(f":{port:04X}")] == [f"0100007F:{port:04X}"]
    with socket.socket(socket.AF_INET6) as other:
        assert other.connect_ex(("::1", port)) != 0


def test_nothing_is_answered_without_the_secret(client, link):
    """By no route: with nothing, with a guess, or with what browsers send by themselves."""
    cookie = {"Cookie": f"secret={client.secret}; allanite_{client.http.base_url.port}={client.secret}"}
    values = ("", "Bearer", "Bearer guess", f"Basic {client.secret}")
    given = [{}, cookie, *({"Authorization": value} for value in values)]
    with Client(link, enter=False) as stranger:
        for route, (method, _) in ROUTES.items():
            path = re.sub(r"\{.*?\}", "x", route.partition(" ")[2])
            assert stranger.http.request(method, path).status_code == (200 if path == "/report.css" else 401), path
        for method, headers in product(("GET", "POST"), given):
            answer = stranger.http.request(method, "/api/workspaces", headers=headers)
            assert answer.status_code == 401, (method, headers)
        assert "open the link that allanite serve prints" in answer.json()["error"]
        assert client.secret not in stranger.get("/").text


def test_a_link_opens_once(client, link):
    with Client(link, enter=False) as other:
        assert other.exchange().status_code == 403
        other.token = other.token[:-1]
        assert other.exchange().status_code == 403
        assert other.http.post("/api/enter").status_code == 403
    assert client.exchange().status_code == 403
    assert not client.http.cookies.jar
    again = client.post("/api/link").json()["link"]
    with Client(again) as other:
        assert other.secret == client.secret


def test_links_are_few_and_grow_old():
    now = [0.0]
    door = Door(None, port=1, clock=lambda: now[0])
    links = [door.link() for _ in range(1000)]
    assert len(set(links)) == 1000
    assert list(door.tokens) == [link.partition("token=")[2] for link in links[-MAX_LINKS:]]
    now[0] = MAX_LINK_AGE_S / 2
    newer = door.link()
    now[0] = MAX_LINK_AGE_S
    last = door.link()
    assert list(door.tokens) == [link.partition("token=")[2] for link in (newer, last)]
    # the one that is an hour old opens nothing, though nobody has asked for another since
    now[0] += MAX_LINK_AGE_S / 2
    statuses = []
    for link in (links[-1], newer, last, last):
        headers = {"Origin": "http://127.0.0.1:1", "Authorization": f"Bearer {link.partition('=')[2]}"}
        statuses.append(answered(door, "POST", "/api/enter", "http://127.0.0.1:1", headers=headers).status_code)
    assert statuses == [403, 403, 200, 403]
    assert door.tokens == {}


@pytest.mark.slow("two servers, one after the other")
def test_a_secret_ends_with_its_server(tmp_path):
    """The next one has another, and so has that of another user; what a killed one has left opens nothing."""
    with served(tmp_path) as (process, link), Client(link) as one:
        ended, (left,) = one.secret, tmp_path.rglob("address")
        kept = left.read_bytes()
        assert ended.encode() in kept
        process.kill()
        process.wait()
    with served(tmp_path) as (_, link), Client(link) as other:
        assert left.read_bytes() != kept
        assert other.secret != ended
        other.hold(ended)
        assert other.get("/api/workspaces").status_code == 401
        assert other.post("/api/workspaces").status_code == 401
    assert not left.exists()
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and ended.encode() in path.read_bytes()]


@rows("host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1.evil.example", ""])
def test_another_host_is_refused(client, host):
    assert raw(client, "/api/tables", host) == 421
    assert raw(client, "/api/tables") == 200


@rows("origin", ["http://evil.example", "null", "", "https://127.0.0.1", "http://127.0.0.1:1"])
def test_another_origin_changes_nothing(client, origin):
    before = client.get("/api/workspaces").json()
    assert client.post("/api/workspaces", headers={"Origin": origin}).status_code == 403
    assert raw(client, "/api/workspaces", method="POST") == 403
    assert client.get("/api/workspaces").json() == before


@rows("path", ["/", "/api/tables", "/nothing", "/api/jobs/x", "/api/enter"])
def test_every_answer_has_the_headers(client, path):
    answer = client.get(path)
    policy = dict(part.split(maxsplit=1) for part in answer.headers["content-security-policy"].split("; "))
    assert policy["default-src"] == "'self'"
    assert "unsafe" not in answer.headers["content-security-policy"]
    assert policy["frame-ancestors"] == "'none'"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert answer.headers["cache-control"] == "no-store"
    assert not [name for name in answer.headers if name.startswith("access-control")]


def test_files_are_of_this_user_alone(client, folder):
    client.workspace()
    store = folder / "allanite" / "serve"
    assert stat.S_IMODE(store.stat().st_mode) == 0o700
    assert stat.S_IMODE((store / "address").stat().st_mode) == 0o600


def test_an_upload_beyond_the_limit_is_refused_and_leaves_nothing(client, folder):
    workspace = client.workspace()
    place = folder / "allanite" / "serve" / workspace
    path = f"/api/workspaces/{workspace}/files"
    stated = client.http.post(path, params={"name": "a.csv"}, content=b"1" * (LIMIT + 1))
    streamed = client.http.post(path, params={"name": "a.csv"}, content=iter([b"1" * 1000] * (LIMIT // 1000 + 1)))
    for answer in (stated, streamed):
        assert (answer.status_code, answer.json()["option"]) == (413, "limit")
        assert "1 MB" in answer.json()["error"]
        assert answer.json()["error"].endswith("open it by its path, or raise the limit with --limit")
    assert [one.name for one in place.iterdir()] == ["state.json"]


@rows(
    "path",
    ["/../../../etc/passwd", "/%2e%2e/%2e%2e/%2e%2e/etc/passwd", "/..%2f..%2f..%2fetc%2fpasswd", "/static/../door.py",
     "/%2e%2e/door.py", "/..\\door.py", "//etc/passwd"],
)  # fmt: skip
def test_no_path_leads_out_of_the_page(client, path):
    assert raw(client, path) == 404


@rows("name", ["..", "../..", "%2e%2e", "0" * 15, "0" * 16 + "/..", "0" * 16 + "-..", "x\0y"])
def test_no_id_is_a_path(client, name):
    quoted = name.replace("\0", "%00").replace("/", "%2f")
    for path in (f"/api/workspaces/{quoted}", f"/api/files/{quoted}/trace", f"/api/jobs/{quoted}"):
        assert client.get(path).status_code == 404, path


HOSTILE = ["../../evil.csv", "/etc/passwd", "a\0b.csv", "<script>alert(1)</script>.csv", "-rf.csv", "CON.csv",
           "\u202egpj.csv", "a" * 5000 + ".csv", "..", "", "x\r\nSet-Cookie: a=b.csv", "--report=x.csv"]  # fmt: skip


@pytest.mark.slow("takes more than half a second")
def test_names_of_files_are_words(client, folder):
    workspace, store = client.workspace(), (folder / "allanite" / "serve").resolve()
    values = "\n".join(f"{value:.4f}" for value in np.random.default_rng(1).normal(0.0, 1.0, 2000))
    data = f"<img src=x onerror=alert(1)> [deg/h]\n{values}\n".encode()
    for count, name in enumerate(HOSTILE, 1):
        answer = client.http.post(f"/api/workspaces/{workspace}/files", params={"name": name}, content=data)
        assert answer.status_code == 200, answer.text
        written = [path for path in store.rglob("data*") if path.stat().st_size == len(data)]
        assert len(written) == count
        assert all(path.name in ("data", "data.csv") for path in written)
        begun = client.ask(workspace, "info", [answer.json()["id"]], {"rate": 10.0, "unit": "deg/h"})
        assert "\n" not in begun.json()["command"]
    assert not list(folder.rglob("evil*"))
    client.http.delete(f"/api/workspaces/{workspace}")


def test_names_of_channels_and_other_verbs(client, tmp_path):
    (tmp_path / "a.csv").write_text("<img src=x onerror=alert(1)> [deg/h]\n" + "1\n2\n4\n" * 500)
    workspace = client.workspace()
    job, last = client.run(workspace, "info", [client.upload(workspace, tmp_path / "a.csv")], {"rate": 10.0})
    assert last[0] == "done"
    (channel,) = client.get(f"/api/jobs/{job}").json()["channels"]
    assert "<img" not in channel["html"]
    assert "&lt;img" in channel["html"] + channel["name"].replace("<", "&lt;")
    client.http.delete(f"/api/workspaces/{workspace}")
    # other verbs are refused
    workspace = client.workspace()
    for verb in ("simulate", "export", "batch", "serve", "example", "--help", ""):
        answer = client.ask(workspace, verb)
        assert answer.status_code == 400
        assert answer.json()["error"].startswith("unknown job")


@rows("key", ["report", "json", "csv", "plot", "force", "recipe", "threads", "lang", "debug", "limits"])
def test_no_choice_writes_or_reads_another_file(client, key, tmp_path):
    target = tmp_path / "written"
    answer = client.ask(client.workspace(), "analyze", (), {key: str(target)})
    assert answer.status_code == 400
    assert f"unknown key '{key}' in the recipe" in answer.json()["error"]
    assert not target.exists()


@rows("body", [b"", b"{", b"[1]", b"null", b"\xff\xfe", b'{"verb": 3, "files": 7}', b"x" * 2_000_000])
def test_requests_that_are_no_requests_are_refused(client, body):
    answer = client.http.post(f"/api/workspaces/{client.workspace()}/jobs", content=body)
    assert answer.status_code == 400
    assert set(answer.json()) == {"error", "option", "exit"}
    assert "internal error" not in answer.text


@pytest.mark.slow("seconds of analyses")
def test_two_tabs_and_two_workspaces_do_not_meet(client, tmp_path):
    one, other = client.workspace(), client.workspace()
    path = tmp_path / "a.csv"
    path.write_text("gx [deg/h]\n" + "1\n2\n" * 300)
    uploaded = client.upload(one, path)
    answer = client.ask(other, "info", [uploaded], {"rate": 10})
    assert answer.json()["error"] == "the file belongs to another workspace"
    assert client.http.delete(f"/api/workspaces/{other}/files/{uploaded}").status_code == 404
    assert client.get(f"/api/workspaces/{one}").json()["files"]


DAMAGED = ("comma.csv", "plain.npy", "described.npz", "plain.parquet", "squeezed.zip", "vn100.txt", "run.lvm")


def words(text, name):
    """An error as a terminal shows it, without the folder of the file."""
    return printable(re.sub(rf"\S*{re.escape(name)}", name, text).strip())


@rows("name", DAMAGED)
@pytest.mark.nightly("damaged files at the page, and at the command line")
def test_a_damaged_file_is_answered_in_the_words_of_the_command_line(client, tmp_path, name):
    workspace, seed = client.workspace(), SEEDS[name]
    data = seed.make()
    for k in range(8):
        rng = generator(name, k)
        path = tmp_path / name
        path.write_bytes(mutated(rng, data))
        recipe = options_of(rng, seed.options)
        _, (kind, told) = client.run(workspace, "analyze", [client.upload(workspace, path)], recipe)
        choices = [part for key, value in recipe.items() for part in (f"--{key}", str(value))]
        result = run("analyze", path, "--quiet", *choices)
        assert (kind == "done") == (result.exit_code in (0, EXCEEDED)), (k, told, result.output)
        if kind != "done":
            error = result.stderr.partition("\ntry: ")[0].removeprefix("error: ")
            assert words(told["error"], name) == words(error, name), k
