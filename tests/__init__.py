"""Everything that must hold: anchors, conformance, recordings, stories, and the parts one by one.

`make test` runs what is not marked ``slow``; `make test-all` then runs the rest, and properties and ensembles with all
their examples. A mark says why: ``@pytest.mark.slow("ensemble of 200 records")``; docs/tests.md lists what went where.
"""

import os
from pathlib import Path

import pytest

from allanite.phrases.phrase import Phrase
from allanite.reporting.language import speaking, tr

ROOT = Path(__file__).resolve().parents[1]
"""Folder of the project."""

ALL = os.environ.get("ALLANITE_TESTS") == "all"
"""Whether this is the run of `make test-all`."""


def examples(most):
    """Number of examples of a property or records of an ensemble: a fifth in `make test`, all in `make test-all`.

    Tests of ensembles are marked ``ensemble``, those of properties are known by hypothesis: both are run twice.
    """
    return most if ALL else max(3, most // 5)


def thinned(cases, keep, why):
    """The cases of a grid: `keep` of them, evenly spread, for `make test`, and the others for `make test-all`."""
    cases = list(cases)
    kept = {round(k * (len(cases) - 1) / max(keep - 1, 1)) for k in range(keep)}
    return [case if k in kept else _slow(case, why) for k, case in enumerate(cases)]


def all_but(cases, slow, why):
    """The cases of a grid, those in `slow` for `make test-all` alone."""
    return [_slow(case, why) if case in slow else case for case in cases]


def _slow(case, why):
    values = case if type(case) is tuple else (case,)  # a named one is a row
    return pytest.param(*getattr(case, "values", values), id=getattr(case, "id", None), marks=pytest.mark.slow(why))


def translated(phrase: Phrase, lang: str) -> str:
    """A phrase as a report in this language shows it: in English, if it is not translated."""
    with speaking(lang):
        return str(tr(phrase))
