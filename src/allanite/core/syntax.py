r"""Text in files of other programs, and models as text: ``N 0.003 deg/sqrt(h), B 0.5 deg/h``.

Names come from recordings: what follows a line break in one would be a line of the file. What cannot be seen, what
would end a comment, and what means more than text in it, is written as an escape of Python: ``\n``, ``\x2d``,
``\u202e``, and a backslash as two.
"""

import json
import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .errors import UsageError

if TYPE_CHECKING:
    from .model import Model

NOTHING = r"(?!)"


def escaped(text: str, meaning: str = NOTHING) -> str:
    """Text on one line, which shows what it holds; of what matches `meaning` the last sign is an escape, too."""
    if "\\" in text or not text.isprintable():
        text = "".join(c if c.isprintable() and c != "\\" else c.encode("unicode_escape").decode() for c in text)
    return re.sub(meaning, lambda found: f"{found[0][:-1]}\\x{ord(found[0][-1]):02x}", text)


@dataclass(frozen=True)
class Syntax:
    """How a file writes text that is not its own."""

    # template of a comment
    comment: str = "# {}"
    meaning: str = NOTHING  # regular expression of what is more than text in a comment
    width: int = 0  # bytes that a line may have; zero if any number
    cell: Callable[[str], str] = escaped  # the encoder of a cell of a table

    def comments(self, text: str) -> list[str]:
        """The lines of a comment."""
        parts = [escaped(text, self.meaning)]
        if self.width:
            ascii_only = parts[0].encode("ascii", "backslashreplace").decode()
            parts = textwrap.wrap(ascii_only, self.width - len(self.comment.format("")), break_on_hyphens=False)
        return [self.comment.format(part) for part in parts]

    @property
    def pattern(self) -> str:
        """Regular expression of a comment."""
        before, _, behind = (part.strip() for part in self.comment.partition("{}"))
        return f"(?s:{re.escape(before)}.*?{re.escape(behind)})" if behind else f"{re.escape(before)}.*"


def _latex(text: str) -> str:
    words = {"^": "asciicircum", "\\": "backslash", "~": "asciitilde", "<": "less", ">": "greater", "|": "bar"}
    signs = {sign: f"\\{sign}" for sign in "&%$#_{}"} | {sign: f"\\text{word}{{}}" for sign, word in words.items()}
    # a bracket or an asterisk at the begin of a row would belong to the end of the row before
    signs |= {"[": "{[}", "*": "{*}"}
    return "".join(signs.get(sign, sign) for sign in escaped(text))


def _markdown(text: str) -> str:
    marks = r"[\\`*\[\]<>|&~$#]|(?<![^\W_])_|_(?![^\W_])|[-+](?= |$)|(?<=\d)[.)](?= |$)"
    return re.sub(marks, r"\\\g<0>", escaped(text))


def uncomputed(text: str) -> str:
    """A cell that a spreadsheet does not compute: with an apostrophe before it, as spreadsheets write text."""
    return f"'{text}" if re.match(r"[=@\t\r]|[+-](?![\d.]+(e[+-]?\d+)?$)", text) else text


YAML = Syntax()

PARAMETERS = Syntax(width=97)
"""Parameters of an autopilot: ArduPilot reads 98 bytes at once, and takes what follows for a line of its own."""

PYTHON = Syntax(meaning="coding[:=]")
"""A comment in the first lines of a script may say how the script is encoded: in UTF-7, letters are line breaks."""

MATLAB = Syntax("% {}", PYTHON.meaning)
C = Syntax("/* {} */", r"\*/|/\*|\?\?")
XML = Syntax("<!-- {} -->", "--")
LATEX = Syntax("% {}", cell=_latex)
MARKDOWN = Syntax(cell=_markdown)

CSV = Syntax(meaning=r'"|[,;][=+@-]', cell=lambda text: uncomputed(escaped(text, "^#|;[=+@-]")))
"""A spreadsheet takes the comments for cells, too, and may separate them by semicolons."""


def json_text(data: Any, indent: int | None = None) -> str:
    """Plain data as JSON that shows what it holds: what cannot be seen is an escape, which is read back the same."""
    text = json.dumps(data, indent=indent, ensure_ascii=False)
    return "".join(c if c.isprintable() or c == "\n" else json.dumps(c)[1:-1] for c in text)


def toml_text(value: Any) -> str:
    """Plain data as a value of TOML; half a character, which TOML cannot hold, as the text of its escape."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml_text(str(key))} = {toml_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_text, value))}]"
    if not isinstance(value, str):
        return str(value).lower() if isinstance(value, bool) else repr(value)
    whole = value.encode("utf-8", "backslashreplace").decode()
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" if ord(c) < 0x10000 else f"\\U{ord(c):08x}"
                   for c in json.dumps(whole, ensure_ascii=False))  # fmt: skip


def toml(choices: dict[str, Any]) -> str:
    """Plain choices as TOML: the keys of a recipe file."""
    return "".join(f"{key} = {toml_text(value)}\n" for key, value in choices.items() if value is not None)


KEYWORDS = ("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global",
            "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while")  # fmt: skip
"""Words of MATLAB that are no variables."""


def identifiers(names: Sequence[str], word: str, *, longest: int = 24, taken: Iterable[str] = ()) -> list[str]:
    """A unique name for each that any language accepts: ASCII letters, digits and _, not among those `taken`."""
    # Upper case does not tell names apart; `word` stands before what does not begin with a letter.
    result, used = list[str](), set(map(str.lower, taken))
    for name in names:
        letters = "".join(c if c.isascii() and c.isalnum() else "_" for c in name).strip("_")[:longest]
        key = first = letters if letters[:1].isalpha() else f"{word}_{letters}".rstrip("_")
        again = 2
        while key.lower() in used:
            key, again = f"{first}_{again}", again + 1
        used.add(key.lower())
        result.append(key)
    return result


NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?")  # a number at the begin of a word


def split_quantities(words: list[str]) -> list[tuple[float, str]]:
    """Numbers with the units that follow them, with or without a space; the unit is empty if none follows.

    >>> split_quantities(["0.1", "deg/h", "20s", "3"])
    [(0.1, 'deg/h'), (20.0, 's'), (3.0, '')]
    """
    quantities: list[tuple[float, str]] = []
    for word in words:
        number = NUMBER.match(word)
        if number:
            quantities.append((float(number[0]), word[number.end() :]))
        elif quantities and not quantities[-1][1]:
            quantities[-1] = (quantities[-1][0], word)
        else:
            raise UsageError(f"expected a number instead of {word!r} in {' '.join(words)!r}, e.g. 0.1 deg/h")
    return quantities


def written(model: "Model") -> str:
    """The text from which `Model` makes exactly the same model.

    >>> from allanite import Model
    >>> model = Model("N 0.003 deg/sqrt(h), GM 0.1 deg/h 20 s")
    >>> Model(written(model)) == model
    True
    """
    texts = list[str]()
    for t in model:
        parameters = zip(t.shape, t.row.parameters, strict=True)
        shape = (f"{float(value)!r} {row.unit}".rstrip() for value, row in parameters)
        texts.append(" ".join([t.symbol, f"{float(t.value)!r}", t.unit, *shape]))
    return ", ".join(texts)
