"""Everything that must hold: anchors, conformance, recordings, stories, and the parts one by one.

Three levels, README.md tells more: `make test` runs what is marked neither ``slow`` nor ``nightly``, continuous
integration what is not marked ``nightly``, and `make nightly` everything, with all examples. A mark says why:
``@pytest.mark.slow("long records")``.
"""

import os
from pathlib import Path

from allanite.core.model import Model, Term
from allanite.core.units import SIGNALS
from allanite.phrases.phrase import Phrase
from allanite.reporting.language import speaking, tr

ROOT = Path(__file__).resolve().parents[1]  # folder of the project
ALL = os.environ.get("ALLANITE_TESTS") == "all"  # whether this is the run of `make nightly`


def examples(most):
    """Number of examples of a property or records of an ensemble: all in `make nightly`, otherwise a fifth."""
    return most if ALL else max(3, most // 5)


def thinned(rows, keep, _why=""):
    """The rows of a table: all in `make nightly`, otherwise so many, evenly spread."""
    rows = list(rows)
    kept = {round(k * (len(rows) - 1) / max(keep - 1, 1)) for k in range(keep)}
    return [row for k, row in enumerate(rows) if ALL or k in kept]


def all_but(rows, long, _why=""):
    """The rows of a table, those in `long` in `make nightly` alone."""
    return [row for row in rows if ALL or row not in long]


def model_of(coefficients, signal=SIGNALS[2]):
    """A model of coefficients in SI by their symbols, of a number without a unit or of another signal."""
    return Model(tuple(Term(symbol, value, signal) for symbol, value in coefficients.items()))


def translated(phrase: Phrase, lang: str) -> str:
    """A phrase as a report in this language shows it: in English, if it is not translated."""
    with speaking(lang):
        return str(tr(phrase))
