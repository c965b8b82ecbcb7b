"""The command line: parse, run a job, render. Each verb is one function and one line of `VERBS`."""

import click

from allanite.core.version import __version__

from .front import Front

VERBS: dict[str, str] = {
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
    "rate": "rate.rate",
    "angle": "angle.angle",
    "simulate": "simulate.simulate",
    "plan": "plan.plan",
    "selfcheck": "plan.selfcheck",
    "statespace": "plan.statespace",
    "export": "export.export",
    "convert": "export.convert",
    "explain": "explain.explain",
    "example": "example.example",
    "budget": "budget.budget",
    "compensate": "compensate.compensate",
    "vertical": "vertical.vertical",
}
"""Name of a verb: module and name of its command. A verb's module is imported when it is requested."""

GROUPS = {
    "Analyze": ("info", "analyze", "batch", "lot", "deviation", "spectrum", "dynamic", "compare", "watch", "serve"),
    "Simulate and plan": ("simulate", "plan", "selfcheck", "statespace"),
    "Use in a filter": ("export", "convert"),
    "Learn": ("explain", "example"),
    "Special jobs": ("rate", "angle", "budget", "compensate", "vertical"),
}
"""Headings of the help, and the verbs below each."""


@click.group(cls=Front, verbs=VERBS, groups=GROUPS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="allanite")
@click.option("--debug", is_flag=True, envvar="ALLANITE_DEBUG", help="Show the traceback of an internal error.")
def main(debug: bool) -> None:
    """Identify the noise of gyroscopes and accelerometers, with confidence intervals."""
