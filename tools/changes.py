"""Join the fragments in changes/ into CHANGELOG.md, below the version of the package.

    python tools/changes.py

A fragment is a file changes/NAME.md: a heading such as "### Read what the logger wrote", which the section of a version
has or gets, and below it the change as an item of a list. It is removed when it is joined.
"""

import re
from collections.abc import Iterable
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOG = ROOT / "CHANGELOG.md"
FRAGMENT = re.compile(r"(### .+)\n\n((?:- .+\n(?:  .+\n)*)+)")


def fragments(root: Path = ROOT) -> list[Path]:
    """Changes that no version has yet."""
    return sorted((root / "changes").glob("*.md"))


def joined(log: str, texts: Iterable[str], version: str, day: date) -> str:
    """A changelog with these fragments in the section of a version, which is begun if it is not the newest.

    Raises
    ------
    ValueError
        If a text is not a heading and a list.
    """
    head, mark, rest = log.partition("\n## ")
    if not rest.startswith(f"{version} "):
        head, rest = head + f"\n## {version} ({day})\n", mark + rest
    else:
        newest, mark, older = rest.partition("\n## ")
        head, rest = f"{head}\n## {newest}", mark + older
    for text in texts:
        if not (found := FRAGMENT.fullmatch(text)):
            raise ValueError(f"a fragment is a line '### Heading', an empty line and items '- ...', not {text!r}")
        heading, items = found.groups()
        before, _, after = head.partition(f"\n{heading}\n")
        own, more, others = after.partition("\n###")
        head = "".join((before, "\n", heading, "\n", own or "\n", items, more, others))
    return head + rest


def main() -> None:
    """Join them, and remove their files."""
    import allanite

    found = fragments()
    texts = [path.read_text("utf-8") for path in found]
    LOG.write_text(joined(LOG.read_text("utf-8"), texts, allanite.__version__, date.today()), "utf-8")
    for path in found:
        path.unlink()


if __name__ == "__main__":
    main()
