"""What a worker needs, loaded before it begins: importing this module makes the process that starts workers ready.

It opens no file and starts no thread, so that the process can be forked safely.
"""

import numpy as np

import allanite.cli
import allanite.reporting.html
import allanite.web.worker
from allanite.cli import VERBS, main
from allanite.core.model import B, N
from allanite.core.record import Recording
from allanite.reporting.json import to_json
from allanite.simulation.record import simulate
from allanite.study.analysis import analyze

from . import faces

SAMPLES = 20_000


def warm() -> None:
    """Load the compiled loops and templates by a small analysis."""
    for verb in VERBS:
        main.get_command(allanite.cli.main.make_context("allanite", ["--"], resilient_parsing=True), verb)
    model = N(0.1, "deg/sqrt(h)") + B(1.0, "deg/h")
    record = simulate(model, SAMPLES, 100.0, rng=np.random.default_rng(1), name="z")
    study = analyze(Recording((record,)))
    faces.described(study, "en")
    to_json(study)


warm()
