"""Where the results of `allanite angle` go: the terminal, standard output, files."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from allanite import __version__
from allanite.core.files import write
from allanite.reporting.outputs import STDOUT, demand_outputs

if TYPE_CHECKING:
    from allanite.angle import Calibration, Harmonics, Plan, Scan
    from allanite.readers.columns.sheet import Sheet

ELSEWHERE = ("file", "report", "plot", "json", "csv", "corrected", "force", "quiet")
"""Options that say nothing of the numbers."""


def made_of(data: "Sheet") -> dict[str, str]:
    """What a result was made of."""
    made = {"source": data.source, "sha256": data.digest, "notes": "; ".join(data.notes)}
    return {"allanite": __version__, **made, "options": said()}


def said() -> str:
    """What the command line says of the job, for who wants to do it again."""
    context = click.get_current_context()
    kept = {name: value for name, value in context.params.items() if name not in ELSEWHERE and value is not None}
    shown = {name: ",".join(map(str, v)) if isinstance(v, tuple) else str(v) for name, v in kept.items()}
    return f"{context.command.name}: " + ", ".join(f"{name.replace('_', '-')} {value}" for name, value in shown.items())


def paths_of(choices: dict[str, Any], inputs: Sequence[str]) -> dict[str, str]:
    """Where results go, once it is known that they can."""
    names = ("report", "plot", "json", "csv", "corrected")
    paths = {name: choices[name] for name in names if choices.get(name) is not None}
    demand_outputs(paths, inputs=inputs, force=choices["force"])
    return paths


def deliver(
    value: "Harmonics | Calibration | Plan | Scan",
    paths: dict[str, str],
    choices: dict[str, Any],
    *,
    made: dict[str, str],
    corrected: dict[str, Any] | None = None,
) -> None:
    """Print the table, and write what was asked for."""
    from allanite.reporting.angle.plain import columns, to_csv, to_json
    from allanite.reporting.angle.text import render

    level, silent = choices["level"], STDOUT in paths.values()
    made = {name: text for name, text in made.items() if text}
    if not (choices["quiet"] or silent):
        if "source" in made:
            click.echo(f"file {made['source']}")
        click.echo(render(value, level), nl=False)
    writers: dict[str, Callable[[], str | bytes]] = {
        "report": lambda: _page(value, level, made),
        "plot": lambda: _figure(value, level, paths["plot"]),
        "json": lambda: to_json(value, level=level, provenance=made),
        "csv": lambda: to_csv(value, level=level),
        "corrected": lambda: columns(corrected or {}),
    }
    for name, path in paths.items():
        put(path, writers[name](), force=choices["force"])
        if path != STDOUT and not choices["quiet"]:
            click.echo(f"{name}: {path}", err=silent)


def _page(value: Any, level: float, made: dict[str, str]) -> str:
    from allanite.reporting.angle.html import page

    return page(value, level=level, provenance=made)


def _figure(value: Any, level: float, path: str) -> bytes:
    from allanite.reporting.angle.figures import plot
    from allanite.reporting.style import encode

    return encode(plot(value, level), Path(path).suffix.lower().lstrip("."))


def put(path: str, data: str | bytes, *, force: bool) -> None:
    """Write `data` to a file or to standard output."""
    raw = data.encode() if isinstance(data, str) else data
    if path == STDOUT:
        click.echo(raw, nl=False)
    else:
        write(path, raw, force=force)
