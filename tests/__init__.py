"""Everything that must hold: anchors, conformance, recordings, stories, and the parts one by one."""

from pathlib import Path

from allanite.core.language import Phrase
from allanite.reporting.language import speaking, tr

ROOT = Path(__file__).resolve().parents[1]
"""Folder of the project."""


def translated(phrase: Phrase, lang: str) -> str:
    """A phrase as a report in this language shows it: in English, if it is not translated."""
    with speaking(lang):
        return str(tr(phrase))
