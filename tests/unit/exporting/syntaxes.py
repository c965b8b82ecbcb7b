"""Files as a parser of their syntax sees them: what is live, and the comments. Text of a file -> (live, comments)."""

import ast
import codecs
import csv
import io
import json
import re
import tokenize
import xml.etree.ElementTree as ET
from xml.parsers import expat

import numpy as np
import yaml
from markdown_it import MarkdownIt

COLUMNS = 8  # columns of a data sheet


def unescaped(text):
    """What `core.syntax.escaped` was given."""
    return codecs.decode(text.encode("latin-1", "backslashreplace"), "unicode_escape")


def _lines(text, mark):
    """Comments of whole lines: a line ends where any program may end it."""
    lines = (line.lstrip() for line in text.splitlines())
    return [unescaped(line.removeprefix(f"{mark} ")) for line in lines if line.startswith(mark)]


def of_yaml(data):
    text = data.decode()
    assert not re.search("[^\n -~\xa1-\U0010ffff]", text)
    live = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    return (yaml.safe_load(text.removeprefix("%YAML:1.0\n")), live), _lines(text, "#")


def of_python(data):
    tokens = list(tokenize.tokenize(io.BytesIO(data).readline))
    assert tokens[0].string == "utf-8"
    comments = [unescaped(token.string.removeprefix("# ")) for token in tokens if token.type == tokenize.COMMENT]
    return ast.dump(ast.parse(data)), comments


def of_xml(data):
    comments = []
    parser = expat.ParserCreate()
    parser.CommentHandler = lambda text: comments.append(unescaped(text[1:-1]))
    parser.Parse(data, True)
    return ET.canonicalize(data.decode(), with_comments=False), comments


def of_c(data):
    """Phases of translation: trigraphs, lines that go on, comments, strings."""
    text = data.decode().replace("??/", "\\")
    text = re.sub(r"\\\r?\n", "", text)
    parts = re.findall(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|.', text, re.DOTALL)
    comments = [unescaped(part[3:-3]) for part in parts if part.startswith("/*")]
    live = "".join(part for part in parts if not part.startswith(("/*", "//")))
    return re.sub("\n+", "\n", live), comments


def of_matlab(data):
    """Strings, comments, blocks of comments, and lines that go on behind three points."""
    live, comments, depth = [], [], 0
    for line in re.split(r"\r\n|[\n\r\f\v\x85\u2028\u2029]", data.decode()):
        depth += {"%{": 1, "%}": -1}.get(line.strip(), 0)
        parts = re.findall(r"""(?<=[\w\])}.])'|'(?:''|[^'])*'|"(?:""|[^"])*"|%.*|\.\.\..*|.""", line)
        comments += [unescaped(part[2:]) for part in parts if part[0] == "%"]
        live += [] if depth else [part for part in parts if part[0] != "%"]
    assert depth == 0
    return "".join(live), comments


def of_parameters(data):
    """AP_Param::read_param_defaults_file: 98 bytes at once; comments as one, since they go on over lines."""
    reader, live = io.BytesIO(data), []
    while part := reader.readline(98):
        if not part.startswith(b"#"):
            live.append(re.split(rb"[,= \t\r\n]+", part))
    text = "".join(line.removeprefix("# ") for line in data.decode("ascii").splitlines() if line.startswith("#"))
    return live, [unescaped(text.replace(" ", ""))]


def of_json(data):
    text = data.decode()
    assert all(sign.isprintable() or sign == "\n" for sign in text)
    held = json.loads(text)
    return held, held.pop("comment")


def of_csv(data):
    """Also as a spreadsheet sees it, with each of its separators."""
    lines = data.decode().splitlines()
    for separator in ",;":
        for cell in (cell for row in csv.reader(lines, delimiter=separator) for cell in row):
            assert not re.match(r"[=@]|[+-](?![\d.]+(e[+-]?\d+)?(,|$))", cell), cell  # a list after a number is none
    rows = list(csv.reader(line for line in lines if line[0] != "#"))
    return [row[1:] for row in rows], _lines("\n".join(lines), "#")


def of_latex(data):
    """Rows of cells; a sign with a meaning that is not one of the text's stops here."""
    text = data.decode()
    code = [re.sub(r"(?<!\\)%.*", "", line) for line in text.splitlines()]
    begin, *rows, end = [line for line in code if line]
    assert end == r"\end{tabular}"
    live = []
    for row in rows:
        assert not re.match(r"[\[*]", row)
        cells = re.split(r" & ", re.sub(r" \\\\( \\hline)?$", "", row))
        assert len(cells) == COLUMNS
        for cell in cells:
            left = re.sub(r"\\text(ascii(circum|tilde)|backslash|less|greater|bar)\{\}|\\[&%$#_{}]|\{[\[*]\}", "", cell)
            assert not re.search(r"[\\&%$#_{}^~\[*<>|]", left), cell
        live.append(cells[1:])
    return (begin, live), _lines(text, "%")


def of_markdown(data):
    """The cells, and the items of the list as comments; nothing is markup."""
    comments, cells, item = [], [], False
    for token in MarkdownIt("commonmark").enable("table").enable("strikethrough").parse(data.decode()):
        assert token.type not in {"html_block", "heading_open", "fence", "blockquote_open"}, token
        item = {"list_item_open": True, "list_item_close": False}.get(token.type, item)
        for part in token.children or ():
            assert part.type in {"text", "text_special", "softbreak"}, part
        if token.type == "inline":
            words = "".join(part.content for part in token.children)
            (comments if item else cells).append(unescaped(words) if item else words)
    assert len(cells) % COLUMNS == 0
    return [cell for i, cell in enumerate(cells) if i % COLUMNS], comments


def of_npz(data):
    held = np.load(io.BytesIO(data))
    return {name: held[name].tolist() for name in held if name != "comment"}, list(map(unescaped, held["comment"]))


PARSERS = {
    ".yaml": of_yaml, ".py": of_python, ".sdf": of_xml, ".h": of_c, ".m": of_matlab, ".param": of_parameters,
    ".params": of_parameters, ".json": of_json, ".csv": of_csv, ".tex": of_latex, ".md": of_markdown, ".npz": of_npz,
}  # fmt: skip
