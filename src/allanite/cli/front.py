"""How the program ends: with a message and an exit code, never with a traceback."""

import atexit
import gc
import os
import re
import shlex
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from itertools import pairwise
from typing import Any, NamedTuple

import click

from allanite.core.errors import AllaniteError, Cure, UnitError, UsageError
from allanite.core.names import row_of, unknown
from allanite.phrases.phrase import command_line
from allanite.plugins import PluginWarning, raised_in, told

from .helping import WithExamples
from .options import demand_filled, with_commas
from .streams import as_sentences, begin, complain, ended, ended_by, lost, while_read

DEFECT, DATA, EXCEEDED, PARTLY, INTERRUPTED = 1, 3, 4, 5, 130
WRITTEN = ("-o", "--output", "--out")  # options by which other verbs name a file
BLAS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""One thread each unless something else is set: products here are short, and handing them to threads takes longer."""

MIN_OBJECTS = 100_000
"""New objects after which those that refer to each other are looked for; imports alone make more than the usual 700."""

LINE = "allanite.line"  # key of the command line in the context

ADDRESS_SPACE_BYTES = 2_500_000_000
"""Address space, bytes, that the program takes with its libraries: 1.9 to 2.2 GB, most of which is never filled."""

TRACKER = "https://github.com/allanite/allanite/issues"


class Failure(click.ClickException):
    """Ends the program with a message on stderr and the exit code `status`; `more` are further lines."""

    def __init__(self, message: str, status: int, *more: str) -> None:
        super().__init__(message)
        self.status, self.more = status, more

    def complained(self) -> int:
        """The exit code, after the message was written."""
        _complain(self.message, self.status)
        if self.more:
            complain(*self.more)
        return self.status


@dataclass(frozen=True)
class Verb:
    """A row of `VERBS`."""

    name: str
    group: str  # the heading of the help that it stands below: one of the others', or a new one
    # the command; or module in `allanite.cli` and name of it, imported when it is requested
    command: str | click.Command
    task: Any = ""  # likewise the `VerbTask` that the page runs; empty if it does not
    synonyms: tuple[str, ...] = ()  # other names by which it is asked for; they are suggested, not taken
    old: tuple[str, ...] = ()  # names that it had, which are taken and not listed

    def imported(self, part: str = "command") -> Any:
        """The command, or the task."""
        row = getattr(self, part)
        if not isinstance(row, str):
            return row
        module, _, name = row.partition(".")
        return getattr(import_module(f"allanite.cli.{module}"), name)

    def demand_whole(self) -> None:
        """Refuse a row whose command has no help, or whose task is none."""
        command = self.imported()
        if not isinstance(command, click.Command):
            raise TypeError(f"its command is a {type(command).__name__}, not a click.Command")
        str.strip(command.get_short_help_str())
        if self.task:
            self.imported("task").kind  # noqa: B018 - imported now


def _given(option: str, words: Sequence[str]) -> bool:
    return any(word.partition("=")[0] == option for word in words)


class Spelling(NamedTuple):
    """Another way to call a verb: `verb` with words by which `other` is meant; the option `dropped` is not its own."""

    verb: str
    other: str
    means: Callable[[Sequence[str]], bool]
    dropped: str = ""


SPELLINGS = (
    Spelling("analyze", "batch", lambda words: _given("--out", words) and any(map(os.path.isdir, words))),
    Spelling("analyze", "lot", lambda words: any(os.path.isfile(os.path.join(w, "files.parquet")) for w in words)),
    Spelling("deviation", "dynamic", partial(_given, "--window")),
    Spelling("plan", "selfcheck", partial(_given, "--verify"), "--verify"),
)


class Front(WithExamples, click.Group):
    """A group of verbs that ends with a message and the documented exit codes, never with a traceback."""

    def __init__(self, *args: Any, verbs: Mapping[str, Verb], **extra: Any) -> None:
        super().__init__(*args, **extra)
        self.verbs = verbs

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The verbs, in the order of their table."""
        return list(self.verbs)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a verb, whose module is imported now; an unknown one is refused."""
        now = cmd_name
        if now not in self.verbs:
            now = next((name for name, verb in self.verbs.items() if now in verb.old), now)
        command: click.Command = row_of("command", now, self.verbs).imported()
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the verbs below the headings of their groups."""
        for group in dict.fromkeys(verb.group for verb in self.verbs.values()):
            with formatter.section(group):
                formatter.write_dl([(v.name, v.imported().get_short_help_str())
                                    for v in self.verbs.values() if v.group == group])  # fmt: skip

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments, and keep them as they were typed."""
        ctx.meta[LINE] = shlex.join(["allanite", *args])
        at = next((i for i, word in enumerate(args) if word in self.verbs), len(args))
        for spelling in SPELLINGS:
            if args[at : at + 1] == [spelling.verb] and spelling.means(args[at + 1 :]):
                rest = (word for word in args[at + 1 :] if word != spelling.dropped)
                return super().parse_args(ctx, [*args[:at], spelling.other, *rest])
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the verb; any exception becomes a `Failure`."""
        _demand_addresses()
        words = shlex.split(ctx.meta[LINE])
        try:
            demand_filled(words)
            verb = next((word for word in words if word in self.verbs), "")
            better = with_commas(words, self.verbs[verb].imported()) if verb else words
            if better != words:
                raise Failure("a list is written with commas", UsageError.exit_code, f"try: {shlex.join(better)}")
            with while_read():
                super().invoke(ctx)
        except click.NoSuchOption as error:
            inner = error.ctx or ctx
            options = {word: param for param in inner.command.params for word in reversed(param.opts)}
            if error.option_name in WRITTEN and "out" in options:  # the file is an argument
                better = [word for word in words if word != error.option_name]
                told = f"{inner.command_path} takes the name of its file without an option"
                raise Failure(told, UsageError.exit_code, f"try: {shlex.join(better)}") from None
            refused = unknown("option", error.option_name, options, listed=False)
            meant = options.get(refused.cure[1])
            if error.option_name.lstrip("-") in getattr(meant, "unlike", ()):
                refused.cure = "", ""
            failure = _failure(refused, ctx)
            failure.more = failure.more or (f"try: {inner.command_path} --help",)
            raise failure from None
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except Exception as error:
            signal = ended_by(error)
            if signal is not None:
                raise signal from None
            if isinstance(error, AllaniteError):
                raise _failure(_elsewhere(error, words), ctx) from None
            if isinstance(error, MemoryError):
                advice = "read fewer channels (--channels) or a part of the record (--from, --until)"
                raise Failure(f"not enough memory; {advice}", DATA) from None
            raise _defect(error, debug=ctx.params["debug"]) from None

    def main(self, *args: Any, **extra: Any) -> Any:
        """Parse, run, and end the program."""
        extra |= {"standalone_mode": False, "prog_name": "allanite"}
        gc.set_threshold(MIN_OBJECTS)
        atexit.register(gc.freeze)  # the system takes all memory back; going through every object takes up to 0.7 s
        for threads in BLAS:
            os.environ.setdefault(threads, "1")
        os.environ["MPLBACKEND"] = "agg"  # figures are written, and a backend that is not there is an error
        begin()
        try:
            with command_line(), ended(), while_read(), as_sentences(PluginWarning):
                code = super().main(*args, **extra) or 0
        except click.exceptions.NoArgsIsHelpError as error:
            complain(*error.format_message().split("\n"))
            code = error.exit_code
        except click.Abort:
            code = _complain("interrupted", INTERRUPTED)
        except Failure as failure:
            code = failure.complained()
        except click.ClickException as error:
            code = _complain(" ".join(error.format_message().split()), error.exit_code)
            context = getattr(error, "ctx", None)
            if context is not None:
                complain(f"try: {context.command_path} --help")
        except Exception as error:  # noqa: BLE001, RUF100 - before a verb runs, as in the help of all
            code = _defect(error, debug="--debug" in sys.argv).complained()
        if lost() and not code:
            code = _complain(f"standard output cannot be written ({lost()}); what should be there is lost", DATA)
        sys.exit(code)


def _failure(error: AllaniteError, ctx: click.Context) -> Failure:
    """The end of the program with an error, and the command that cures it if the error says what to type."""
    words = shlex.split(ctx.meta[LINE])
    better = cured(words, error.cure)
    more = [f"  {line}" for line in error.more] + [f"try: {shlex.join(better)}"] * (better != words)
    return Failure(error.message, error.exit_code, *more)


def _defect(error: Exception, *, debug: bool) -> Failure:
    """The end of the program with an error that is nobody's intention: of a plug-in if it was running, else our own."""
    package = raised_in(error)
    where, whom = (f" in the package {package!r}", " to its maintainers") if package else ("", f": {TRACKER}")
    what = " ".join(told(error).split())
    report = f"internal error{where} ({what}); please report it with the command and the file{whom}"
    return Failure(report, DEFECT, *("".join(traceback.format_exception(error)).splitlines() if debug else ()))


def _elsewhere(error: AllaniteError, words: list[str]) -> AllaniteError:
    """The error of a unit that is a target of export: it was asked of a verb that does not write it."""
    options = dict(pairwise(words))
    target = options.get("--to", options.get("--output-unit"))
    if not isinstance(error, UnitError) or target is None or repr(target) not in str(error):
        return error
    from allanite.exporting.exports import EXPORTS

    verb = words[1]
    meant = UsageError(f"{target} is not a unit: {verb} does not write its file, export does", cure=(verb, "export"))
    return meant if target in EXPORTS else error


def cured(words: list[str], cure: Cure) -> list[str]:
    """The words of a command with a part replaced where it occurs last, or with options added, instead of old ones.

    >>> cured(["allanite", "deviation", "avar.csv", "--statistic=avar"], ("avar", "oadev"))
    ['allanite', 'deviation', 'avar.csv', '--statistic=oadev']
    """
    typed, instead = cure
    if not typed:
        added = shlex.split(instead)
        again = {word for word in added if word.startswith("--")}
        old = {place for i, word in enumerate(words) if word in again for place in (i, i + 1)}
        return [w for i, w in enumerate(words) if i not in old and w.partition("=")[0] not in again] + added
    part = re.compile(rf"(?<![^\s,=]){re.escape(typed)}(?![^\s,=])")
    at = next((i for i in reversed(range(len(words))) if part.search(words[i])), None)
    return [part.sub(lambda _: instead, word) if i == at else word for i, word in enumerate(words)]


def _demand_addresses() -> None:
    """Refuse to begin where libraries could not be loaded: some would end the program, others blame their own files."""
    try:
        from resource import RLIM_INFINITY, RLIMIT_AS, getrlimit
    except ImportError:  # a system without such limits
        return
    most, _ = getrlimit(RLIMIT_AS)
    if most not in (RLIM_INFINITY, -1) and most < ADDRESS_SPACE_BYTES:
        need = f"needs about {ADDRESS_SPACE_BYTES / 1e9:g} GB of address space with its libraries"
        raise Failure(f"not enough memory: allanite {need}, and {most / 1e9:.3g} GB are allowed (ulimit -v)", DATA)


def _complain(message: str, code: int) -> int:
    complain(message, before=click.style("error: ", fg="red", bold=True))
    return code
