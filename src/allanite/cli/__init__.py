"""The command line: parse, run a job, render. Each verb is one function and one line of `GROUPS`."""

from collections.abc import Mapping

import click

from allanite.core.version import __version__
from allanite.plugins import Table

from .front import Front

GROUPS: dict[str, dict[str, str]] = {
    "Analyze": {
        "info": "analyze.info",
        "analyze": "analyze.analyze",
        "batch": "batch.batch",
        "lot": "batch.lot",
        "deviation": "curves.deviation",
        "spectrum": "curves.spectrum",
        "dynamic": "curves.dynamic",
        "compare": "compare.compare",
        "watch": "watch.watch",
        "serve": "serve.serve",
    },
    "Simulate and plan": {
        "simulate": "simulate.simulate",
        "plan": "plan.plan",
        "selfcheck": "plan.selfcheck",
        "statespace": "plan.statespace",
    },
    "Use in a filter": {"export": "export.export", "convert": "export.convert"},
    "Learn": {"explain": "explain.explain", "example": "example.example"},
    "Special jobs": {
        "rate": "rate.rate",
        "angle": "angle.angle",
        "budget": "budget.budget",
        "compensate": "compensate.compensate",
        "vertical": "vertical.vertical",
    },
}
"""Headings of the help, and the verbs below each: module and name of its command, imported when it is requested."""

VERBS: Mapping[str, str | click.Command] = Table(
    {verb: command for verbs in GROUPS.values() for verb, command in verbs.items()},
    "allanite.verbs", kind=click.Command, key="name",
)  # fmt: skip
"""Module and name of the command of every verb, and the commands of plug-ins."""


@click.group(cls=Front, groups=GROUPS, verbs=VERBS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="allanite")
@click.option("--debug", is_flag=True, envvar="ALLANITE_DEBUG", help="Show the traceback of an internal error.")
def main(debug: bool) -> None:
    """Identify the noise of gyroscopes and accelerometers, with confidence intervals."""
