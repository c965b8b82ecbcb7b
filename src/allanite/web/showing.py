"""Routes of what is shown of a recording and of a result, and of what is saved."""

from typing import Any

from fastapi import Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from allanite.core.errors import UsageError
from allanite.core.names import demand_name
from allanite.reporting.sheet import toml

from . import trace
from .messages import body_of
from .worker import FORMS

REFITTED = ("terms", "band", "method", "level", "outliers")
"""Choices of a refit."""


def traced(request: Request, file: str, channel: str = "", points: int = 2000) -> dict[str, Any]:
    """A part of the trace of a channel."""
    store = request.app.state.store
    store.file(file)
    given = [request.query_params.get(key) for key in ("from", "to")]
    try:
        start, end = (float(text) if text else None for text in given)
    except ValueError:
        raise UsageError(f"the window of a trace is in seconds, not {given!r}") from None
    return trace.window(store.place(file), channel, start, end, points)


def deviation(
    request: Request, name: str, channel: str = "", statistic: str = "oadev", lang: str = ""
) -> dict[str, Any]:
    """A curve with its band, its model, and each term."""
    lang = lang or request.app.state.jobs.job(name)["lang"]
    found: dict[str, Any] = request.app.state.jobs.ask(
        name, "deviation", channel=channel, statistic=statistic, lang=lang
    )
    return found


async def refit(request: Request, name: str) -> dict[str, Any]:
    """A channel with other terms or another band."""
    asked, jobs = await body_of(request), request.app.state.jobs
    arguments = {
        "channel": str(asked.get("channel")),
        "choices": {key: asked[key] for key in REFITTED if asked.get(key)},
        "statistics": list(asked.get("statistics") or []),
        "lang": asked.get("lang") or jobs.job(name)["lang"],
    }
    found: dict[str, Any] = await run_in_threadpool(lambda: jobs.ask(name, "refit", **arguments))
    return found


async def export(request: Request, name: str) -> dict[str, Any]:
    """The file of a target."""
    asked, jobs = await body_of(request), request.app.state.jobs
    arguments = {"channels": list(asked.get("channels") or []), "target": str(asked.get("target")),
                 "choices": asked, "form": str(asked.get("form") or "")}  # fmt: skip
    found: dict[str, Any] = await run_in_threadpool(lambda: jobs.ask(name, "export", **arguments))
    return found


def save(  # noqa: PLR0917 - parameters of the query
    request: Request, name: str, form: str, lang: str = "", inline: bool = False, dark: bool = False
) -> Response:
    """A file to download, as the command line writes it; a figure is shown `inline`, for a `dark` ground."""
    jobs = request.app.state.jobs
    found = jobs.job(name)
    how = "inline" if inline and form.startswith("figure") else "attachment"
    if form == "recipe":
        return _download(toml(found["recipe"]).encode(), "recipe.toml", "application/toml; charset=utf-8")
    demand_name("form", form, (*FORMS, "recipe"))
    _, path, kind = FORMS[form]
    data = jobs.result(name)[0] if form == "json" else jobs.ask(
        name, "save", form=form, lang=lang or found["lang"], dark=dark and form == "figure.svg")["data"]  # fmt: skip
    return _download(data, f"allanite-{path}", kind, how)


def _download(data: bytes, name: str, kind: str, how: str = "attachment") -> Response:
    return Response(data, media_type=kind, headers={"Content-Disposition": f'{how}; filename="{name}"'})
