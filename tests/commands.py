"""Commands as they are typed, in this process."""

from functools import partial

from click.testing import CliRunner

from allanite.cli import main


def run(*words, code=None, **how):
    """How a command ends, with this code if one is given, and what it says; words of any type are typed as text."""
    done = CliRunner().invoke(main, [*map(str, words)], **how)
    assert code is None or done.exit_code == code, done.output
    return done


def of_verb(*verb):
    """The same of one verb, whose words are given first."""
    return partial(run, *verb)


def ends(done, code, *said):
    """Check how a command has ended, and what it says: of what went wrong, on standard error."""
    text = " ".join((done.stderr if code else done.stdout).split())
    assert (done.exit_code, "Traceback" in done.output) == (code, False), done.output
    assert [words for words in said if " ".join(words.split()) not in text] == [], text
