"""Routes of jobs: begun, asked for, followed, cancelled."""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

from fastapi import Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response, StreamingResponse

from allanite.core.syntax import toml

from .jobs import Jobs
from .messages import body_of
from .schema import JobBody, Lang

QUIET = 0.05
"""Seconds between looks for new events."""

ALIVE = 10.0
"""Seconds after which a stream of events without any says that it is there."""


async def begin(request: Request, name: str) -> dict[str, Any]:
    """Begin a job."""
    asked = await body_of(request, JobBody)
    job = await run_in_threadpool(request.app.state.jobs.begin, name, asked)
    return {"job": job["id"], "command": job["command"]}


async def job(request: Request, name: str, lang: Lang = "") -> Response:
    """A job with its result."""
    jobs = request.app.state.jobs
    found = jobs.job(name)
    parts = {key: found[key] for key in ("id", "state", "verb", "recipe", "lang", "files", "target", "command")}
    text = json.dumps(parts | {"problem": found["problem"], "toml": toml(found["recipe"])})
    if found["state"] != "done":
        return Response(text, media_type="application/json")
    value, shown = await run_in_threadpool(jobs.result, name)
    if lang and lang != found["lang"]:
        shown = json.dumps(await jobs.ask(name, "described", lang=lang)).encode()
    body = text[:-1].encode() + b', "value": ' + value.strip() + b", " + shown.strip()[1:]
    return Response(body, media_type="application/json")


async def events(request: Request, name: str) -> StreamingResponse:
    """What a job reports, as it comes."""
    jobs = request.app.state.jobs
    found = jobs.job(name)
    jobs.resume(jobs.store.state(name.partition("-")[0]))
    return StreamingResponse(_stream(jobs, found), media_type="text/event-stream")


async def _stream(jobs: Jobs, job: dict[str, Any]) -> AsyncIterator[str]:
    live = jobs.live.get(job["id"])
    if live is None:
        kind = "done" if job["state"] == "done" else "failed"
        problem = job["problem"] or {"error": job["state"], "option": None, "exit": 130}
        yield _event(kind, {} if kind == "done" else problem)
        return
    sent, quiet = 0, 0.0
    while True:
        over = live.over  # before the events are looked at: the last one is among them then
        for number, kind, data in live.events:
            if number >= sent:
                sent, quiet = number + 1, 0.0
                yield _event(kind, data)
        if over:
            return
        quiet += QUIET
        if quiet >= ALIVE:
            quiet = 0.0
            yield ": still there\n\n"
        await asyncio.sleep(QUIET)


def _event(kind: str, data: dict[str, Any]) -> str:
    return f"event: {kind}\ndata: {json.dumps(data)}\n\n"


def cancel(request: Request, name: str) -> dict[str, Any]:
    """Cancel a job."""
    request.app.state.jobs.cancel(name)
    return {}
