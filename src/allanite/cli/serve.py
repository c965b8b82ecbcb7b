"""``allanite serve``: the page in the browser."""

from typing import Any

import click

from .helping import command
from .options import integer, options


@command()
@options(
    click.argument("files", nargs=-1, type=click.Path(), metavar="[FILE]..."),
    click.option("--port", type=integer(0, 65535), default=0, metavar="N",
        help="Port at 127.0.0.1.  [default: any that is free]"),
    click.option("--browser/--no-browser", default=True, help="Open the page in the browser."),
    click.option("--limit", default="4GB", show_default=True, metavar="SIZE", help="Size of an upload at most."),
    click.option("--quota", default="20GB", show_default=True, metavar="SIZE",
        help="Size of all files that the page keeps."),
    "lang",
)  # fmt: skip
def serve(files: tuple[str, ...], **choices: Any) -> None:
    """Open the page in the browser.

    Drop a file, look, cut, switch, overlay, compare, export: everything on this machine, at 127.0.0.1, by the jobs of
    the other commands, whose command line the page shows. Uploads and results are kept in the cache folder of this
    user, and are there again after a reload or a restart.
    """
    from allanite.core.errors import demand_extra
    from allanite.readers.parts import bytes_of

    demand_extra("web", "fastapi", "uvicorn", what="the page")
    from allanite.web.server import serve as run

    run(files, **choices | {name: bytes_of(choices[name], name) for name in ("limit", "quota")})
