"""README and the pages of the documentation: what they show to be typed, and what that is run on."""

import re
import shlex
import shutil
from pathlib import Path

from tests import ROOT
from tests.commands import run

SAMPLE = "examples/tactical_gyro.csv"
WRITING = ("--report", "--plot", "--csv")  # options with the name of a file that is then looked at


def text_of(page):
    """The text of a page, of README by its whole name."""
    return (ROOT / ("" if page == "README.md" else "docs") / page).read_text("utf-8")


def fenced(page, language):
    """The blocks of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text_of(page), re.DOTALL | re.MULTILINE)


def commands(page):
    """The commands of a page, those that go on in the next line joined."""
    lines = (line for block in fenced(page, "sh") for line in block.replace("\\\n", " ").splitlines())
    return [line for line in lines if line.startswith("allanite ")]


def stated(script):
    """What a program says behind each print that it prints."""
    return re.findall(r"^print\(.*\)  # (.*)$", script, re.MULTILINE)


def furnish(folder):
    """A folder as somebody who follows a page has it: the sample, and a plain column of numbers."""
    (folder / "examples").mkdir()
    shutil.copy(ROOT / SAMPLE, folder / SAMPLE)
    rows = (ROOT / SAMPLE).read_text("utf-8").splitlines()[5:]
    (folder / "FILE").write_text("\n".join(row.split(",")[1] for row in rows), "utf-8")
    return folder


def typed(command, *more, writing=WRITING):
    """Run a command of a page in this process and folder: what it prints. Files that it names are no small ones."""
    words = [*shlex.split(command)[1:], *more]
    done = run(*words, code=0)
    for option in set(writing) & set(words):
        assert Path(words[words.index(option) + 1]).stat().st_size > 1000, command
    return done.output
