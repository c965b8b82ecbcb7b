"""Where results go and in which form: the terminal, standard output, files."""

import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from allanite.core.errors import LongJobWarning, UsageError
from allanite.core.files import demand_writable, encoded, write
from allanite.reporting.digits import WRITTEN
from allanite.reporting.fonts import FontWarning
from allanite.reporting.language import ENGLISH, catalogue, speaking
from allanite.study.recipe import Recipe

from .front import DATA, LINE
from .options import FLAGS
from .streams import as_sentences, complain, hand_over, show, while_read

if TYPE_CHECKING:
    from allanite.core.record import Recording
    from allanite.reporting.first import First

DEFAULT_COLUMNS = 120  # width of text where no terminal limits it


def text_of(value: Any, out: "Outputs", first: "Callable[[], First] | None" = None) -> str:
    """A result as text for the terminal, at its width: the first screen, all of it, or a line for each channel."""
    from allanite.reporting import first_screen, table

    terminal, encoding = sys.stdout.isatty(), sys.stdout.encoding or "utf-8"
    width = shutil.get_terminal_size().columns if terminal else DEFAULT_COLUMNS
    form: dict[str, Any] = {
        "width": width, "color": terminal and "NO_COLOR" not in os.environ, "lang": out.lang,
        "ascii": len(WRITTEN.encode(encoding, "ignore").decode(encoding)) < len(WRITTEN),
    }  # fmt: skip
    if out.details and not out.brief:
        text = table(value, **form)
    else:
        text = first_screen(value, **form, brief=out.brief, first=first and first(), written=out.paths)
    # characters that the terminal cannot encode are escaped, not an error
    return text.encode(encoding, "backslashreplace").decode(encoding)


def rendered(value: Any, name: str, path: str, lang: str, command: str = "") -> str | bytes:
    """A result in the form that option `name` writes; a page says the command line that made it."""
    from allanite import reporting
    from allanite.reporting.json import to_json

    if name == "json":
        return to_json(value)
    if name in ("csv", "coefficients"):
        return reporting.to_csv(value, coefficients=name == "coefficients")
    if name == "plot":
        from allanite.reporting.printing import encode

        with speaking(lang):
            return encode(reporting.plot(value, lang=lang), Path(path).suffix.lower().lstrip("."))
    form = reporting.document if path.lower().endswith(".pdf") else reporting.page
    return form(value, command=command, lang=lang)


Settings = TypeVar("Settings")
Progress = Callable[[str, float], None]

STDOUT = "-"

PRINTED = ("json", "csv", "coefficients", "output")  # options that may write to standard output


@dataclass(frozen=True)
class Outputs:
    """Where a result is written: name of the option -> path, and how."""

    paths: Mapping[str, str]
    force: bool = False
    quiet: bool = False
    strict: bool = False
    lang: str = ENGLISH
    details: bool = False
    brief: bool = False
    threads: int | None = 1

    @property
    def piped(self) -> bool:
        """Whether a result is written to standard output."""
        return STDOUT in self.paths.values()


def outputs(choices: dict[str, Any], inputs: Sequence[str | None], *, also: Sequence[str] = ()) -> Outputs:
    """Take the output options out of `choices`, and refuse before any work what could not be written afterwards."""
    named = ((name, choices.pop(name, None)) for name in ("report", "plot", *PRINTED, *also))
    paths = {name: path for name, path in named if path is not None}
    out = Outputs(paths, **{name: choices.pop(name) for name in (*FLAGS, "threads") if name in choices})
    catalogue(out.lang)  # an unknown language is refused now
    if list(paths.values()).count(STDOUT) > 1:
        raise UsageError("only one result can be written to standard output; give a file for the other one")
    taken = {os.path.realpath(path): "the input" for path in inputs if path is not None}
    for name, path in paths.items():
        if path == STDOUT and name in PRINTED:
            continue
        where = os.path.realpath(path)
        if where in taken:
            raise UsageError(f"--{name} would overwrite {taken[where]} {path!r}; give another name")
        taken[where] = f"--{name}"
        if name == "plot":
            from allanite.reporting.style import demand_figure_path

            demand_figure_path(path, force=out.force)
        elif name == "report" and os.path.splitext(path)[1].lower() not in ("", ".html", ".htm", ".pdf"):
            raise UsageError(f"a report is written as .html or .pdf, by its suffix, not as {path!r}")
        else:
            demand_writable(path, force=out.force)
    return out


def demand_recording(path: str | None) -> None:
    """Refuse, before any work, a recording whose format cannot be written."""
    from allanite.readers.formats.registry import writer_for

    if path is not None:
        writer_for(os.path.splitext(path)[1].lower())


def recipe_of(choices: dict[str, Any], **usual: Any) -> Recipe:
    """Take the keys of a recipe out of `choices`; `usual` holds defaults that differ from the recipe's."""
    choices.pop("recipe", None)
    known = {key: choices.pop(key) for key in [f.name for f in fields(Recipe)] if key in choices}
    return Recipe.from_dict(usual | given(known))


def settings_of(kind: "type[Settings]", choices: dict[str, Any]) -> "Settings":
    """Take the settings of this class out of `choices`; those not given keep their defaults."""
    named = [f.name for f in fields(kind) if f.name in choices]  # type: ignore[arg-type]  # a dataclass
    return kind(**given({name: choices.pop(name) for name in named}))


def given(choices: dict[str, Any]) -> dict[str, Any]:
    """The options that were given."""
    return {key: value for key, value in choices.items() if value is not None}


def carry_out(job: Callable[[Progress], Any], out: Outputs, extra: "Extra | None" = None) -> Any:
    """Run a job that reports its progress, and deliver its result."""
    from allanite.parallel.processors import FIGURES, PAGE, importing, processes

    page = out.paths.get("report", "")
    printed = "plot" in out.paths or page.lower().endswith(".pdf")
    with processes(out.threads), importing(FIGURES if printed else PAGE if page else ()):
        with progress(out) as tell:
            result = job(tell)
        deliver(result, out, extra)
    if out.strict and result.rejected:
        names = ", ".join(name or "the record" for name in result.rejected)
        complain(f"not explained, or without a result: {names}")
        raise click.exceptions.Exit(DATA)
    return result


@contextmanager
def progress(out: Outputs) -> Iterator[Progress]:
    """A progress bar on stderr if it is a terminal; warnings are printed as sentences."""
    from allanite.reporting.progress import bar

    with as_sentences(LongJobWarning), bar(shown=sys.stderr.isatty() and not out.quiet) as tell:
        yield tell


@dataclass(frozen=True)
class Extra:
    """Outputs of a verb beyond the usual forms: name of the option -> function that makes it; and its first screen."""

    data: Mapping[str, Callable[[Any], str | bytes]] = field(default_factory=dict)
    recordings: "Mapping[str, Callable[[Any], Recording]]" = field(default_factory=dict)
    first: "Callable[[], First] | None" = None


def deliver(value: Any, out: Outputs, extra: Extra | None = None) -> None:
    """Print a result, unless --quiet is given or standard output is taken, and write the requested files."""
    more, context = extra or Extra(), click.get_current_context(silent=True)
    command = "" if context is None else context.meta.get(LINE, "")
    places = [(name, *place) for name, path in out.paths.items() for place in _places(value, path)]
    with as_sentences(FontWarning):
        if not (out.quiet or out.piped):
            text = text_of(value, out, more.first)
            with while_read():
                hand_over(text, styled=True)
        for name, path, part in places:
            if name in more.recordings:
                from allanite.readers import write as write_recording

                write_recording(more.recordings[name](value), path, force=out.force)
            else:
                made = more.data[name](part) if name in more.data else rendered(part, name, path, out.lang, command)
                put(path, made, force=out.force)
            if path != STDOUT and not out.quiet:
                with while_read():
                    (complain if out.piped else show)(f"{name}: {path}")


CHANNEL = "{channel}"  # stands in the path of a figure for the name of a channel: each has a file of its own then


def _places(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """The files of a path, each with the part of the result that it shows."""
    if CHANNEL not in path:
        yield path, value
        return
    apart = getattr(value, "apart", ())
    if not apart:
        raise UsageError(f"{path!r} is a file for each channel, but this result has none; leave out {CHANNEL}")
    names = [re.sub(r"[^\w.+-]+", "_", name).strip("_.") for name, _ in apart]
    for i, (name, (_, part)) in enumerate(zip(names, apart, strict=True)):
        own = name if name and name not in names[:i] else f"{name}{i + 1}"
        yield path.replace(CHANNEL, own), part


def put(path: str, data: str | bytes, *, force: bool) -> None:
    """Write `data` to a file or to standard output."""
    raw = encoded(data) if isinstance(data, str) else data
    if path == STDOUT:
        with while_read():
            hand_over(raw)
    else:
        write(path, raw, force=force)
