"""The row of the table of verbs."""

from allanite.cli import Verb

from .command import EXTENT, extent

VERB = Verb("extent", "Analyze", extent, EXTENT)
