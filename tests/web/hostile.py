"""Hostile requests to the page in the browser and damaged files of its folder: the kind `page` of benchmarks/fuzz.py.

Request k has the seed "page k", damage k of a file that of `tests.hostile.generator`. Requests go to every route of the
application, with the workspaces, files and jobs that are there, and with others; a job that is begun by one is
cancelled, or waited for. A failure is a status of 500 or more, an answer without a sentence, an internal error of a
job, or a workspace that cannot be read any more.
"""

import asyncio
import json
import random
import shutil
from collections.abc import Callable
from pathlib import Path

import httpx
import numpy as np
from tests.hostile import generator, mutated

from allanite.cli import jobs as verbs
from allanite.core.choices import choices_of
from allanite.core.errors import DataError
from allanite.exporting.exports import EXPORTS
from allanite.exporting.fields import How
from allanite.study.recipe import Recipe
from allanite.web import schema
from allanite.web.jobs import UNFINISHED, Jobs
from allanite.web.server import application
from allanite.web.store import Store

RAW = (
    b"", b"{", b"[1]", b"null", b"\xff\xfe", b'{"a":NaN}', b'{"a":1e999}', b'{"a":"\\ud800"}', b'{"a":' * 90_000,
    b'{"a":' + b"9" * 5000 + b"}", b'{"a":1' + b"0" * 400 + b"}", b"[" * 40 + b"]" * 40,
)  # fmt: skip
"""Bodies that are no object, or hold what cannot be kept."""

WORDS = (
    "", "x", "\0", "\n", "..", "../../x", "/etc/passwd", "nan", "inf", "-inf", "1e308", "-1", "0", "1e999", "9" * 400,
    "<img src=x onerror=alert(1)>", "\u202egpj", "a" * 5000, "--help", "gx", "N", "NBK", "0.1,10", "100..160",
    "oadev", "theo1", "all", "log", "1,2,3", "deg/h", "gyro=deg/s", "ru", "xx", "report", "csv", "figure.svg",
    "kalibr", "each", "yes", "N 0.1 deg/h", "10 min", "%", "{}", "1 1", "=", ":", ",",
)  # fmt: skip
NUMBERS = (0, 1, -1, 2, 10**15, 10**300, 1e308, -1e308, 5e-324, 0.5, 100, 1e-9, True, None)


def value(rng: random.Random, deep: int = 3):
    """Plain data: mostly a word or a number, else a list or an object of some."""
    kind = rng.random()
    if kind < 0.5 or not deep:
        return rng.choice(WORDS)
    if kind < 0.8:
        return rng.choice(NUMBERS)
    parts = [value(rng, deep - 1) for _ in range(rng.randrange(4))]
    return parts if kind < 0.92 else {rng.choice(WORDS): part for part in parts}


SOUND = {
    "channel": "gx", "statistic": "hdev", "lang": "ru", "form": "coefficients", "points": "50", "from": "1", "to": "9",
    "dark": "0", "name": "a.csv",
}  # fmt: skip
"""Parameters of a query that can be answered."""

BODIES = {
    "jobs": schema.JobBody, "refit": schema.RefitBody, "export": schema.ExportBody, "open": schema.PathBody,
    "example": schema.ExampleBody,
}  # fmt: skip


class Page:
    """The application in this process, on a folder with a workspace that has a file and a result."""

    def __init__(self, folder: Path) -> None:
        self.store = Store(folder, limit=10**6, quota=10**8)
        self.store.clear()
        self.jobs = Jobs(self.store)
        self.app = application(self.store, self.jobs, {"lang": "en", "workspace": None})
        self.app.state.door = self
        transport = httpx.ASGITransport(self.app, raise_app_exceptions=False)
        self.http = httpx.AsyncClient(transport=transport, base_url="http://page")
        self.routes = [(r.path, next(iter(r.methods)), r) for r in self.app.routes if getattr(r, "methods", None)]
        self.ids = {"name": ["0" * 16], "file": ["0" * 16], "job": []}

    def link(self) -> str:
        """In the place of the door."""
        return "http://page"

    async def prepare(self) -> None:
        """Make the workspace."""
        self.home = (await self.http.post("/api/workspaces")).json()["id"]
        rows = "\n".join(map(str, np.random.default_rng(1).normal(size=1500).round(4)))
        place = f"/api/workspaces/{self.home}"
        made = await self.http.post(f"{place}/files?name=g.csv", content=f"gx [deg/h]\n{rows}\n")
        self.file = made.json()["id"]
        asked = {"verb": "analyze", "files": [self.file], "recipe": {"rate": 100}}
        self.job = (await self.http.post(f"{place}/jobs", json=asked)).json()["job"]
        await self.ended(self.job)

    async def ended(self, job: str) -> dict:
        """A job that is over."""
        while (job_now := self.jobs.job(job))["state"] in UNFINISHED:
            await asyncio.sleep(0.02)
        return job_now

    def drawn(self, rng: random.Random) -> tuple[str, str, str, dict, bytes]:
        """A request: its route, method, path, query and body."""
        route, method, row = rng.choice(self.routes)
        own = {"/api/jobs": self.job, "/api/workspaces": self.home}
        name = next((one for begin, one in own.items() if route.startswith(begin)), "")
        parts = {"name": name, "file": self.file, "rest:path": "x"}
        drops = method == "DELETE"
        path = route
        for key, one in parts.items():
            junk = rng.choice(("0" * 16, "x", "..", "%00", "%ff", f"{'0' * 16}-{'0' * 16}", "a" * 3000, self.file))
            path = path.replace(f"{{{key}}}", junk if drops or rng.random() < 0.1 else one)
        query = [p.alias for p in row.dependant.query_params] + ["name"]
        given = {key: rng.choice(WORDS) if rng.random() < 0.2 else SOUND[key] for key in query if rng.random() < 0.6}
        return f"{method} {route}", method, path, given, self._body(rng, route)

    def _body(self, rng: random.Random, route: str) -> bytes:
        if rng.random() < 0.15:
            return rng.choice(RAW)
        kind = BODIES.get(route.rpartition("/")[2])
        if kind is None or rng.random() < 0.1:
            return json.dumps({rng.choice(WORDS): value(rng) for _ in range(rng.randrange(4))}).encode()
        plausible = {
            "verb": verbs(), "files": ([self.file], [self.file] * 2, []), "target": ("datasheet",) * 9 + tuple(EXPORTS),
            "lang": ("en", "ru", ""), "channel": ("gx",), "channels": ([], ["gx"]), "statistics": ([], ["hdev"]),
            "name": ("mems",), "recipe": ({"rate": 100},),
        }  # fmt: skip
        body = {key: rng.choice(plausible.get(key, (None,))) for key in kind.model_fields}
        if kind is schema.JobBody:
            body["target"] = ""
            body["recipe"] = {"rate": 100} | {
                rng.choice(list(choices_of(Recipe))): value(rng) for _ in range(rng.randrange(3))
            }
        if kind is schema.ExportBody:
            body |= {rng.choice(list(choices_of(How))): value(rng) for _ in range(rng.randrange(3))}
        if kind is schema.PathBody or rng.random() < 0.3:
            body[rng.choice(list(body))] = value(rng)
        return json.dumps({key: part for key, part in body.items() if part is not None}).encode()

    async def outcome(self, rng: random.Random) -> None:
        """Ask; raise what is wrong, or an error in words where the request is refused."""
        route, method, path, query, body = self.drawn(rng)
        if "/events" in route:  # followed until its job ends
            return
        answer = await self.http.request(method, path, params=query, content=body, timeout=None)
        if wrong := await self._wrong(answer, route):
            raise AssertionError(f"{method} {path} {query} {body[:300]!r}: {wrong}")
        if answer.status_code >= 400:
            raise DataError(f"status {answer.status_code}: {answer.json()['error'][:900]}")

    async def _wrong(self, answer: httpx.Response, route: str) -> str:
        if answer.status_code >= 400:
            sentence = answer.json()["error"] if answer.status_code < 500 and answer.content[:1] == b"{" else ""
            return "" if len(sentence) > 8 else f"{answer.status_code} {answer.text[:200]}"
        if route.endswith("/jobs"):
            job = answer.json()["job"]
            if self.jobs.job(job)["verb"] == "watch":
                self.jobs.cancel(job)
                self.jobs.cancel(job)
            problem = (await self.ended(job))["problem"]
            if problem and problem["exit"] == 1:
                return problem["error"]
        home = await self.http.get(f"/api/workspaces/{self.home}")
        return "" if home.status_code == 200 else f"afterwards {home.status_code} {home.text[:200]}"

    async def looked(self) -> str:
        """What is wrong with the answers to whoever looks at everything; what is damaged is refused in words."""
        always, job = ("workspaces", "tables"), f"jobs/{self.job}"
        for path in (*always, f"workspaces/{self.home}", job, f"files/{self.file}/trace", f"{job}/save?form=recipe"):
            answer = await self.http.get(f"/api/{path}")
            worded = answer.status_code == 200 or (answer.status_code < 500 and len(answer.json()["error"]) >= 10)
            if not worded or (path in always and answer.status_code != 200):
                return f"{path}: {answer.status_code} {answer.text[:300]}"
        return ""


def prepared(folder: Path) -> tuple[Page, asyncio.Runner]:
    """A page that is prepared, and what runs its requests."""
    runner, opened = asyncio.Runner(), Page(folder)
    runner.run(opened.prepare())
    return opened, runner


def requests(opened: Page, runner: asyncio.Runner) -> Callable[[int], object]:
    """What asks the page for request k."""
    return lambda k: runner.run(opened.outcome(random.Random(f"page {k}")))  # noqa: S311 - no secret


def damage(opened: Page, runner: asyncio.Runner, name: str) -> Callable[[int], object]:
    """What opens a copy of a sound folder in which a file, named by its end, has damage k."""
    sound, copy = Path(shutil.copytree(opened.store.folder, "sound")), Path("copy")

    def take(k: int) -> None:
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(sound, copy)
        (path,) = copy.rglob(f"*{name}")
        path.write_bytes(mutated(generator(name, k), path.read_bytes()))
        other = Page(copy)
        other.home, other.file, other.job = opened.home, opened.file, opened.job
        if wrong := runner.run(other.looked()):
            raise AssertionError(wrong)

    return take
