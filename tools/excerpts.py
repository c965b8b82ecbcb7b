"""Renew what pages show: each block of the kind `console` is run, and figures are those of their tables.

    python tools/excerpts.py [--check] [PAGE ...]

Without pages: the README and all pages of the documentation. With --check, nothing is written, and the exit code is 1
if a page shows something else than its commands print. Commands run one after the other in a folder of the page, which
has the sample; a command that fails ends this one. `| head -14`, `| tail -5` and `| grep gz` shorten what is shown.
Figures of tables are renewed as tools/figures.py does, on every page.
"""

import argparse
import contextlib
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from click.testing import CliRunner

import figures
from allanite.cli import main
from allanite.cli.front import EXCEEDED

ROOT = Path(__file__).resolve().parents[1]
SAMPLE = Path("examples", "tactical_gyro.csv")
BLOCK = re.compile(r"(?<=^```console\n)(.*?)(?=^```)", re.DOTALL | re.MULTILINE)
SHORTENED: dict[str, Callable[[list[str], str], list[str]]] = {
    "head": lambda lines, count: lines[: -int(count)],
    "tail": lambda lines, count: lines[int(count) :],
    "grep": lambda lines, words: [line for line in lines if words in line],
}
"""What a page may pipe its output through: the part of the usual command that pages need."""


def pages() -> list[Path]:
    """The README, and every page that is written by hand."""
    docs = ROOT / "docs"
    return [ROOT / "README.md", *sorted([*docs.glob("*.md"), *docs.glob("translations/*.md")])]


def commands(block: str) -> list[str]:
    """Commands of a block, without their prompts."""
    return re.findall(r"^\$ (.*)$", block, re.MULTILINE)


def output(command: str) -> list[str]:
    """Lines that a command prints in this folder, after its pipes."""
    words, *pipes = _split(shlex.split(command))
    done = CliRunner().invoke(main, words[1:], prog_name=words[0])
    if done.exit_code not in (0, EXCEEDED):  # a contradiction is an answer
        raise SystemExit(f"{command}: exit code {done.exit_code}\n{done.output}")
    lines = done.stdout.splitlines()
    for name, argument in pipes:
        lines = SHORTENED[name](lines, argument)
    return [line.rstrip() for line in "\n".join(lines).strip("\n").splitlines()]


def _split(words: list[str]) -> list[list[str]]:
    ends = [-1, *(k for k, word in enumerate(words) if word == "|"), len(words)]
    return [words[start + 1 : end] for start, end in pairwise(ends)]


def renewed(text: str) -> str:
    """A page with the output of today."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "examples").mkdir()
        shutil.copy(ROOT / SAMPLE, folder / SAMPLE)
        with contextlib.chdir(folder):
            return BLOCK.sub(lambda found: _renewed(found[1]), text)


def _renewed(block: str) -> str:
    shown = [[f"$ {command}", *output(command)] for command in commands(block)]
    return "".join(f"{line}\n" for lines in shown for line in lines)


def renew() -> None:
    """Renew or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="*", type=Path)
    parser.add_argument("--check", action="store_true", help="end with exit code 1 if a page is not up to date")
    asked, stale = parser.parse_args(), 0
    figures.main(["--check"] if asked.check else [])
    for page in asked.pages or pages():
        text = page.read_text("utf-8")
        new = renewed(text) if BLOCK.search(text) else text
        if new != text:
            stale += 1
            print(f"{page.name}: {'not up to date: run python tools/excerpts.py' if asked.check else 'renewed'}")
            if not asked.check:
                page.write_text(new, "utf-8")
    sys.exit(bool(asked.check and stale))


if __name__ == "__main__":
    renew()
