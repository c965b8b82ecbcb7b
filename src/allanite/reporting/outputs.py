"""The files that a result can become: what goes into each, and whether it may be written."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from allanite.core.errors import UsageError
from allanite.core.files import demand_writable

if TYPE_CHECKING:
    from allanite.study.analysis import Study
    from allanite.study.survey import Survey

STDOUT = "-"


def _page(study: "Study", _: str) -> bytes:
    from .html import page

    return page(study).encode()


def _figure(value: "Study | Survey", path: str) -> bytes:
    from allanite.reporting import plot

    from .style import encode

    return encode(plot(value, level=value.recipe.level), Path(path).suffix.lower().lstrip("."))


def _json(value: "Study | Survey", _: str) -> bytes:
    from .plain import to_json

    return to_json(value).encode()


def _csv(value: "Study | Survey", _: str) -> bytes:
    from .plain import to_csv

    return to_csv(value).encode()


OUTPUTS: dict[str, Callable[[Any, str], bytes]] = {"report": _page, "plot": _figure, "json": _json, "csv": _csv}
"""Name of the option that asks for it: what the file holds."""

PRINTED = ("json", "csv")
"""What may go to standard output."""


def demand_outputs(paths: Mapping[str, str], *, inputs: Sequence[str], force: bool) -> None:
    """Refuse before the work begins what could not be written after it.

    Parameters
    ----------
    paths : name in `OUTPUTS` -> path
    inputs : sequence of path
        Files that are read; they are never overwritten.
    force : bool
        Whether other files that exist may be.

    Raises
    ------
    UsageError
        A file exists, cannot be written, or two things would go to the same place.
    """
    if list(paths.values()).count(STDOUT) > 1:
        raise UsageError("only one thing can go to standard output; give the other one a file")
    taken = {os.path.realpath(path): "the input" for path in inputs}
    for name, path in paths.items():
        if path == STDOUT and name in PRINTED:
            continue
        where = os.path.realpath(path)
        if where in taken:
            raise UsageError(f"--{name} would overwrite {taken[where]} {path!r}; give it another name")
        taken[where] = f"--{name}"
        _demand_place(name, path, force=force)


def _demand_place(name: str, path: str, *, force: bool) -> None:
    if name == "plot":
        from .style import demand_figure_path

        demand_figure_path(path, force=force)
    else:
        demand_writable(path, force=force)
