"""A server of the page in a process of its own, and a client that has entered it."""

import json
import os
import signal
import subprocess
import sys
from contextlib import contextmanager

import httpx

WAIT = 120.0


@contextmanager
def served(folder, *arguments):
    """A server whose cache is in `folder`; gives its process and the link that it prints."""
    environment = os.environ | {"XDG_CACHE_HOME": str(folder)}
    process = subprocess.Popen(
        [sys.executable, "-m", "allanite.cli", "serve", "--no-browser", *map(str, arguments)],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        finally:
            process.stdout.close()
            process.stderr.close()


class Client:
    """What the page does, without a browser."""

    def __init__(self, link, enter=True):
        self.link, self.base = link, link.partition("/?")[0]
        self.http = httpx.Client(base_url=self.base, headers={"Origin": self.base}, timeout=WAIT, trust_env=False)
        if enter:
            answer = self.http.get(link)
            assert answer.status_code == 303, answer.text

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.http.close()

    def again(self):
        """A client that has the cookie of this one."""
        other = Client(self.link, enter=False)
        other.http.cookies = self.http.cookies
        return other

    def get(self, path, **query):
        return self.http.get(path, params=query)

    def post(self, path, data=None, **extra):
        return self.http.post(path, json=data or {}, **extra)

    def workspace(self):
        return self.post("/api/workspaces").json()["id"]

    def upload(self, workspace, path, name=None):
        answer = self.http.post(
            f"/api/workspaces/{workspace}/files", params={"name": name or path.name}, content=path.read_bytes()
        )
        assert answer.status_code == 200, answer.text
        return answer.json()["id"]

    def begin(self, workspace, verb, files, recipe=None, **extra):
        answer = self.post(
            f"/api/workspaces/{workspace}/jobs", {"verb": verb, "files": files, "recipe": recipe or {}} | extra
        )
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

    def run(self, workspace, verb, files, recipe=None, **extra):
        """A job to its end: its id, and its last event."""
        job = self.begin(workspace, verb, files, recipe, **extra)
        return job, list(self.events(job))[-1]
