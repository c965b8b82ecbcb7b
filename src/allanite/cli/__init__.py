"""The command line: parse, analyze, render. One verb is one function and one line of `VERBS`."""

import click

from allanite import __version__

from .analyze import analyze, info
from .angle import angle
from .budget import budget
from .compare import compare
from .compensate import compensate
from .curves import deviation, dynamic, spectrum
from .front import Front
from .plan import plan
from .rate import rate
from .reading import reading
from .selfcheck import selfcheck
from .simulate import simulate
from .statespace import statespace

VERBS: dict[str, click.Command] = {
    "info": info,
    "analyze": analyze,
    "deviation": deviation,
    "spectrum": spectrum,
    "dynamic": dynamic,
    "compare": compare,
    "rate": click.command("rate")(reading(rate)),
    "angle": angle,
    "simulate": simulate,
    "plan": plan,
    "selfcheck": selfcheck,
    "statespace": statespace,
    "budget": click.command("budget")(reading(budget)),
    "compensate": click.command("compensate")(reading(compensate)),
}


@click.group(cls=Front, commands=VERBS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="allanite")
@click.option("--debug", is_flag=True, envvar="ALLANITE_DEBUG", help="Show where a defect is.")
def main(debug: bool) -> None:
    """Noise coefficients of gyroscopes and accelerometers, with honest intervals."""
