"""What a worker needs, loaded before it begins: importing this module makes the process that starts workers ready.

It starts no thread and compiles nothing, so that the process can be forked safely, and at once.
"""

from importlib import import_module

import allanite.cli
import allanite.kernels.ahead
import allanite.reporting.html
import allanite.reporting.views.analysis
import allanite.web.worker
from allanite.cli import VERBS, main
from allanite.parallel.processors import IDENTIFICATION


def warm() -> None:
    """Load the commands and what the identification of noise needs."""
    for name in (*IDENTIFICATION, "scipy.optimize"):
        import_module(name)
    for verb in VERBS:
        main.get_command(allanite.cli.main.make_context("allanite", ["--"], resilient_parsing=True), verb)


warm()
