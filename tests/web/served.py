"""A server of the page in a process of its own, and a client that has entered it."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx

WAIT = 120.0  # seconds after which something that should come does not come any more

PLUGIN = Path(__file__).with_name("plugin")
"""Where the format of `waiting_job` is installed, for a server that is `waiting`."""


def answered(application, method, path, base="http://page", **request):
    """The answer of an application in this process; as in the server, an error that is not answered is raised."""

    async def ask():
        async with httpx.AsyncClient(transport=httpx.ASGITransport(application), base_url=base) as client:
            return await client.request(method, path, **request)

    with ThreadPoolExecutor(1) as thread:  # in this one a browser may hold a loop that runs
        return thread.submit(lambda: asyncio.run(ask())).result()


@contextmanager
def served(folder, *arguments, waiting=False):
    """A server whose cache is in `folder`; gives its process and the link that it prints."""
    environment = os.environ | {"XDG_CACHE_HOME": str(folder)} | ({"PYTHONPATH": str(PLUGIN)} if waiting else {})
    process = subprocess.Popen(
        [sys.executable, "-m", "allanite.cli", "serve", "--no-browser", *map(str, arguments)],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(WAIT)
        except subprocess.TimeoutExpired:
            process.kill()
        process.stdout.close()
        process.stderr.close()


class Told:
    """A connection that keeps what is said of traces."""

    def __init__(self):
        self.problems = []

    def send(self, message):
        if message[0] == "trace":
            self.problems.append(message[1]["problem"])


class Client:
    """What the page does, without a browser."""

    def __init__(self, link, enter=True):
        self.link, self.others = link, []
        self.base, _, self.token = link.partition("/#token=")
        self.http = httpx.Client(base_url=self.base, headers={"Origin": self.base}, timeout=WAIT, trust_env=False)
        if enter:
            answer = self.exchange()
            assert answer.status_code == 200, answer.text
            self.hold(answer.json()["secret"])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for client in (self, *self.others):
            client.http.close()

    @property
    def secret(self):
        """What was given for the token."""
        return self.http.headers["Authorization"].removeprefix("Bearer ")

    def exchange(self):
        """The answer to the token of the link."""
        return self.http.post("/api/enter", headers={"Authorization": f"Bearer {self.token.partition('&')[0]}"})

    def hold(self, secret):
        """Send a secret with every request from now on."""
        self.http.headers["Authorization"] = f"Bearer {secret}"

    def again(self):
        """A client that has the secret of this one, and is closed with it."""
        other = Client(self.link, enter=False)
        other.hold(self.secret)
        self.others.append(other)
        return other

    def get(self, path, **query):
        return self.http.get(path, params=query)

    def post(self, path, data=None, **extra):
        return self.http.post(path, json=data or {}, **extra)

    def workspace(self):
        return self.post("/api/workspaces").json()["id"]

    def upload(self, workspace, path, name=None):
        place, named = f"/api/workspaces/{workspace}/files", {"name": name or path.name}
        answer = self.http.post(place, params=named, content=path.read_bytes())
        assert answer.status_code == 200, answer.text
        return answer.json()["id"]

    def ask(self, workspace, verb, files=(), recipe=None, **extra):
        """The answer to who begins a job."""
        asked = {"verb": verb, "files": list(files), "recipe": recipe or {}} | extra
        return self.post(f"/api/workspaces/{workspace}/jobs", asked)

    def begin(self, *asked, **extra):
        answer = self.ask(*asked, **extra)
        assert answer.status_code == 200, answer.text
        return answer.json()["job"]

    def events(self, job):
        """Name and data of each event of a job, until its end."""
        with self.http.stream("GET", f"/api/jobs/{job}/events") as answer:
            assert answer.status_code == 200
            kind = ""
            for line in answer.iter_lines():
                if line.startswith("event: "):
                    kind = line[7:]
                elif line.startswith("data: "):
                    yield kind, json.loads(line[6:])

    def run(self, *asked):
        """A job to its end: its id, and its last event."""
        job = self.begin(*asked)
        return job, list(self.events(job))[-1]


def waiting_file(folder):
    """A pipe, and a file that is read until the pipe is opened and closed."""
    pipe, path = folder / "pipe", folder / "waiting.dat"
    os.mkfifo(pipe)
    path.write_text(f"WAIT {pipe}\n", encoding="utf-8")
    return pipe, path


@contextmanager
def waiting_job(client, folder, workspace=None):
    """A job that goes on until it is cancelled or the context ends: its workspace and id; it has begun to read."""
    pipe, path = waiting_file(folder)
    workspace = workspace or client.workspace()
    file = client.post(f"/api/workspaces/{workspace}/open", {"path": str(path)}).json()["id"]
    job = client.begin(workspace, "info", [file])
    with open(pipe, "wb"):  # once the job has opened the other end
        next(client.events(job))
        yield workspace, job
