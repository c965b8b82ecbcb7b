"""Commands as they are typed, in this process."""

from functools import partial

from click.testing import CliRunner

from allanite.cli import main


def run(*words, **how):
    """How a command ends, and what it says; words of any type are typed as text."""
    return CliRunner().invoke(main, [*map(str, words)], **how)


def of_verb(*verb):
    """The same of one verb, whose words are given first."""
    return partial(run, *verb)
