"""The application of the page: its routes, and what is answered to errors."""

from importlib.resources import files
from typing import Any

from fastapi import FastAPI
from starlette.staticfiles import StaticFiles

from . import filing, running, showing
from .jobs import Jobs
from .messages import ANSWERED, Answer, answered
from .store import MissingError, Store


def application(store: Store, jobs: Jobs, first: dict[str, Any]) -> FastAPI:
    """The application behind the door; `first` is what the page opens with: workspace and language."""
    # nothing is reported anywhere, whatever the environment asks for
    app = FastAPI(
        docs_url=None, redoc_url=None, openapi_url=None, redirect_slashes=False, telemetry={"auto_configure": False},
        default_response_class=Answer,
    )  # fmt: skip
    app.state.store, app.state.jobs, app.state.first = store, jobs, first
    for kind in ANSWERED:
        app.add_exception_handler(kind, answered)
    for path, (method, endpoint) in ROUTES.items():
        app.add_api_route(path.partition(" ")[2], endpoint, methods=[method], response_model=None)
    app.mount("/", StaticFiles(directory=str(files("allanite.web") / "static"), html=True))
    return app


def nowhere(rest: str) -> None:
    """Whatever else begins like a route is none: it never names a file."""
    raise MissingError(f"there is no route {rest!r}")


ROUTES: dict[str, tuple[str, Any]] = {
    "get /api/tables": ("GET", filing.menus),
    "get /report.css": ("GET", filing.style),
    "post /api/link": ("POST", filing.link),
    "get /api/workspaces": ("GET", filing.workspaces),
    "post /api/workspaces": ("POST", filing.new_workspace),
    "get /api/workspaces/{name}": ("GET", filing.workspace),
    "delete /api/workspaces/{name}": ("DELETE", filing.drop_workspace),
    "put /api/workspaces/{name}/choices": ("PUT", filing.choices),
    "post /api/workspaces/{name}/files": ("POST", filing.upload),
    "delete /api/workspaces/{name}/files/{file}": ("DELETE", filing.drop_file),
    "post /api/workspaces/{name}/open": ("POST", filing.opened),
    "post /api/workspaces/{name}/example": ("POST", filing.example),
    "post /api/workspaces/{name}/jobs": ("POST", running.begin),
    "get /api/jobs/{name}": ("GET", running.job),
    "get /api/jobs/{name}/events": ("GET", running.events),
    "post /api/jobs/{name}/cancel": ("POST", running.cancel),
    "get /api/files/{file}/trace": ("GET", showing.traced),
    "get /api/jobs/{name}/deviation": ("GET", showing.deviation),
    "post /api/jobs/{name}/refit": ("POST", showing.refit),
    "post /api/jobs/{name}/export": ("POST", showing.export),
    "get /api/jobs/{name}/save": ("GET", showing.save),
    "get /api/{rest:path}": ("GET", nowhere),
}
"""Method and path of each route: its function."""
