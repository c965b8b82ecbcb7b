"""The help of a verb: what it does, three examples, and its options in groups, the most used of them at first."""

import tomllib
from collections.abc import Callable
from inspect import cleandoc
from pathlib import Path
from typing import Any

import click

from allanite.study.recipe import IDENTIFYING, READING, SELECTING

MOST = 12  # options that are shown unless all are asked for
OWN = 4  # options of the verb itself among them, at least
ALL = "allanite.help"  # key in the context: whether all options are asked for

USED = ("target", "output", "models", "sensor", "datasheet", "unit", "rate", "channels", "report", "time", "details",
        "terms", "start", "json", "plot", "end", "recipe", "taus", "statistic", "scale", "kind", "level", "csv",
        "force")  # fmt: skip
"""Names of the options that are typed most, in this order."""

GROUPS = {
    "Reading": READING, "Selecting": SELECTING, "Identification": (*IDENTIFYING, "strict"),
    "Output": (
        "output", "report", "plot", "json", "csv", "coefficients", "lang", "details", "brief", "force", "quiet",
        "threads", "recipe", "help",
    ),
}  # fmt: skip
"""Headings with the names of their options; others are those of the verb."""


class WithExamples(click.Command):
    """A command whose help has examples."""

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The summary, the examples, and the rest of the description."""
        examples = tomllib.loads(Path(__file__).with_name("examples.toml").read_text("utf-8"))
        lines = [f"allanite {line}" for line in examples.get(str(self.name), [])]
        summary, _, rest = cleandoc(self.help or "").partition("\n\n")
        for text in filter(None, (summary, "\n".join(["\b", *lines]) if lines else "", rest)):
            formatter.write_paragraph()
            with formatter.indentation():
                formatter.write_text(text)


class VerbCommand(WithExamples):
    """A verb whose help is short: ``--help all`` shows every option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Take the word behind --help out of the arguments."""
        at = next((i + 1 for i, word in enumerate(args) if word in ("--help", "-h")), len(args))
        ctx.meta[ALL] = args[at : at + 1] == ["all"]
        return super().parse_args(ctx, [*args[:at], *args[at + ctx.meta[ALL] :]])

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The options below their headings."""
        options = [p for p in self.get_params(ctx) if isinstance(p, click.Option) and not p.hidden]
        shown = options if ctx.meta.get(ALL) else _most_used(options)
        heading = {name: title for title, names in GROUPS.items() for name in names}
        for title in ("Options", *GROUPS):
            rows = [p.get_help_record(ctx) for p in shown if heading.get(str(p.name), "Options") == title]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(list(filter(None, rows)))
        if len(shown) < len(options):
            formatter.write_paragraph()
            formatter.write_text(f"{len(options) - len(shown)} more options: {ctx.command_path} --help all")


def _most_used(options: list[click.Option]) -> list[click.Option]:
    """The first of the verb itself, and the most used ones; all if they are few."""
    if len(options) <= MOST + 2:
        return options
    common = {name for names in GROUPS.values() for name in names}
    own = [option for option in options if option.name not in common]
    used = sorted((o for o in options if o.name in USED), key=lambda option: USED.index(str(option.name)))
    kept = list(dict.fromkeys([*own[:OWN], *used, *own, *options]))[:MOST]
    return [option for option in options if option in kept or option.name == "help"]


def command() -> Callable[[Callable[..., Any]], VerbCommand]:
    """Make a function a verb."""
    return click.command(cls=VerbCommand)
