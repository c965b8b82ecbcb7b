"""The row of the table of verbs."""

from allanite.cli import Verb

from .command import extent

EXTENT = Verb("extent", "Analyze", extent)
