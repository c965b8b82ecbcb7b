"""The command line: parse, run a job, render. Each verb is one function and one line of `VERBS`."""

from typing import Any

import click

from allanite.core.names import demand_name
from allanite.core.version import __version__
from allanite.plugins import Registry

from .front import Front, Verb

__all__ = ["VERBS", "Verb", "jobs", "main", "task_of"]

_OWN = (
    Verb("info", "Analyze", "analyze.info", "tasks.INFO", synonyms=("inspect", "show")),
    Verb("analyze", "Analyze", "analyze.analyze", "tasks.ANALYZE", synonyms=("identify", "fit", "allan", "avar")),
    Verb("batch", "Analyze", "analyze.batch"),
    Verb("lot", "Analyze", "analyze.lot"),
    Verb("deviation", "Analyze", "analyze.deviation", "tasks.DEVIATION", synonyms=("oadev", "dev")),
    Verb("spectrum", "Analyze", "analyze.spectrum", "tasks.SPECTRUM", synonyms=("psd", "asd", "welch")),
    Verb("dynamic", "Analyze", "analyze.dynamic", "tasks.DYNAMIC"),
    Verb("compare", "Analyze", "compare.compare", "tasks.COMPARE", synonyms=("diff",)),
    Verb("check", "Analyze", "compare.check", synonyms=("conform", "verify")),
    Verb("watch", "Analyze", "analyze.watch", "tasks.WATCH", synonyms=("live", "stream", "monitor")),
    Verb("serve", "Analyze", "serve.serve", synonyms=("gui", "web")),
    Verb("simulate", "Simulate and plan", "simulate.simulate", synonyms=("generate", "synth")),
    Verb("plan", "Simulate and plan", "compare.plan"),
    Verb("drift", "Simulate and plan", "compare.drift", synonyms=("navigation", "error")),
    Verb("selfcheck", "Simulate and plan", "compare.selfcheck"),
    Verb("statespace", "Simulate and plan", "compare.statespace"),
    Verb("export", "Use in a filter", "export.export", synonyms=("kalibr",)),
    Verb("convert", "Use in a filter", "export.convert", synonyms=("units",)),
    Verb("explain", "Learn", "export.explain"),
    Verb("example", "Learn", "simulate.example"),
    Verb("rate", "Special jobs", "special.rate"),
    Verb("angle", "Special jobs", "angle.angle"),
    Verb("quantization", "Special jobs", "special.quantization", old=("budget",)),
    Verb("compensate", "Special jobs", "special.compensate", synonyms=("calibrate",)),
    Verb("vertical", "Special jobs", "special.vertical"),
)
"""The verbs in the order of the help, below the headings of their groups."""

VERBS = Registry({verb.name: verb for verb in _OWN}, "allanite.verbs", kind=Verb, key="name", demand=Verb.demand_whole)


def jobs() -> list[str]:
    """The verbs that the page can run."""
    return [name for name, verb in VERBS.items() if verb.task]


def task_of(verb: str) -> Any:
    """The `VerbTask` of a verb."""
    demand_name("job", verb, jobs())
    return VERBS[verb].imported("task")


@click.group(cls=Front, verbs=VERBS, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="allanite")
@click.option("--debug", is_flag=True, envvar="ALLANITE_DEBUG", help="Show the traceback of an internal error.")
def main(debug: bool) -> None:
    """Identify the noise of gyroscopes and accelerometers, with confidence intervals."""
