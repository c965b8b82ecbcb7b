"""Routes of what is shown of a recording and of a result, and of what is saved."""

from typing import Annotated, Any

from fastapi import Query, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from allanite.core.names import demand_name
from allanite.core.syntax import toml

from . import trace
from .jobs import Jobs
from .messages import body_of
from .schema import ExportBody, Lang, RefitBody
from .worker import FORMS


def traced(  # noqa: PLR0917 - parameters of the query
    request: Request, file: str, channel: str = "", points: int = 2000,
    start: Annotated[float | None, Query(alias="from", allow_inf_nan=False)] = None,
    end: Annotated[float | None, Query(alias="to", allow_inf_nan=False)] = None,
) -> dict[str, Any]:  # fmt: skip
    """A part of the trace of a channel."""
    store = request.app.state.store
    store.file(file)
    return trace.window(store.place(file), channel, start, end, points)


async def deviation(
    request: Request, name: str, channel: str = "", statistic: str = "oadev", lang: Lang = ""
) -> dict[str, Any]:
    """A curve with its band, its model, and each term."""
    jobs: Jobs = request.app.state.jobs
    lang = lang or jobs.job(name)["lang"]
    return await jobs.ask(name, "deviation", channel=channel, statistic=statistic, lang=lang)


async def refit(request: Request, name: str) -> dict[str, Any]:
    """A channel with other terms or another band."""
    asked: RefitBody = await body_of(request, RefitBody)
    jobs: Jobs = request.app.state.jobs
    choices = asked.model_dump(exclude={"channel", "statistics", "lang"})
    lang = asked.lang or jobs.job(name)["lang"]
    return await jobs.ask(name, "refit", channel=asked.channel, choices=choices, statistics=asked.statistics, lang=lang)


async def export(request: Request, name: str) -> dict[str, Any]:
    """The file of a target."""
    asked: ExportBody = await body_of(request, ExportBody)
    jobs: Jobs = request.app.state.jobs
    return await jobs.ask(
        name, "export", channels=asked.channels, target=asked.target, choices=asked.model_extra, form=asked.form
    )


async def save(request: Request, name: str, form: str, lang: Lang = "", dark: bool = False) -> Response:
    """A file as the command line writes it; a figure may be for a `dark` ground."""
    jobs: Jobs = request.app.state.jobs
    found = jobs.job(name)
    if form == "recipe":
        return _download(toml(found["recipe"]).encode(), "recipe.toml", "application/toml; charset=utf-8")
    demand_name("form", form, (*FORMS, "recipe"))
    _, path, kind = FORMS[form]
    if form == "json":
        return _download((await run_in_threadpool(jobs.result, name))[0], f"allanite-{path}", kind)
    made = await jobs.ask(name, "save", form=form, lang=lang or found["lang"], dark=dark and form == "figure.svg")
    return _download(made["data"], f"allanite-{path}", kind)


def _download(data: bytes, name: str, kind: str) -> Response:
    return Response(data, media_type=kind, headers={"Content-Disposition": f'attachment; filename="{name}"'})
