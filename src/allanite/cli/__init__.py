"""The command line: parse, run a job, render. One verb is one function and one line of `VERBS`."""

import click

from allanite.core.version import __version__

from .front import Front

VERBS: dict[str, str] = {
    "info": "analyze.info",
    "analyze": "analyze.analyze",
    "deviation": "curves.deviation",
    "spectrum": "curves.spectrum",
    "dynamic": "curves.dynamic",
    "compare": "compare.compare",
    "rate": "rate.rate",
    "angle": "angle.angle",
    "simulate": "simulate.simulate",
    "plan": "plan.plan",
    "selfcheck": "plan.selfcheck",
    "statespace": "plan.statespace",
    "budget": "budget.budget",
    "compensate": "compensate.compensate",
}
"""Name of a verb: module and name of its command. A verb's module is imported when it is asked for."""


@click.group(cls=Front, verbs=VERBS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="allanite")
@click.option("--debug", is_flag=True, envvar="ALLANITE_DEBUG", help="Show where a defect is.")
def main(debug: bool) -> None:
    """Noise coefficients of gyroscopes and accelerometers, with honest intervals."""
