"""The forms of a result: text for the terminal, and what the options for outputs write."""

import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from allanite.reporting.digits import WRITTEN
from allanite.reporting.language import speaking

if TYPE_CHECKING:
    from collections.abc import Callable

    from allanite.parallel.sharing import Work
    from allanite.reporting.first import First

    from .deliver import Outputs

WIDTH = 120
"""Width of text where no terminal limits it."""


def text_of(value: Any, out: "Outputs", first: "Callable[[], First] | None" = None) -> str:
    """A result as text for the terminal, at its width: the first screen, all of it, or a line for each channel."""
    from allanite.reporting import first_screen, table

    terminal, encoding = sys.stdout.isatty(), sys.stdout.encoding or "utf-8"
    width = shutil.get_terminal_size().columns if terminal else WIDTH
    form: dict[str, Any] = {
        "width": width, "color": terminal and "NO_COLOR" not in os.environ, "ascii": not _encodes(WRITTEN, encoding),
        "lang": out.lang,
    }  # fmt: skip
    if out.details and not out.brief:
        text = table(value, **form)
    else:
        text = first_screen(value, **form, brief=out.brief, first=first and first())
    # characters that the terminal cannot encode are escaped, not an error
    return text.encode(encoding, "backslashreplace").decode(encoding)


def _encodes(text: str, encoding: str) -> bool:
    try:
        return bool(text.encode(encoding))
    except UnicodeEncodeError:
        return False


def encoded(value: Any, name: str, path: str, lang: str, command: str = "") -> str | bytes:
    """A result in the form that option `name` writes; a page says the command line that made it."""
    from allanite.parallel.sharing import made

    return made(work_of(value, name, path, lang, command))


def work_of(value: Any, name: str, path: str, lang: str, command: str = "") -> "Work[str | bytes]":
    """The making of the same, of which processes can share a page and the results of channels."""
    from allanite import reporting
    from allanite.parallel.sharing import Work
    from allanite.reporting.json import json_of

    def drawn(_: Any) -> bytes:
        from allanite.reporting.style import encode

        with speaking(lang):
            return encode(reporting.plot(value, lang=lang), Path(path).suffix.lower().lstrip("."))

    if name == "json":
        return json_of(value)
    if name in ("csv", "coefficients"):
        return Work((), lambda _: reporting.to_csv(value, coefficients=name == "coefficients"))
    if name == "plot":
        return Work((), drawn)
    if path.lower().endswith(".pdf"):
        return Work((), lambda _: reporting.document(value, command=command, lang=lang))
    return reporting.page_of(value, command=command, lang=lang)
