"""Every number of the search is said: what it bounds, its unit, and where it comes from."""

import ast

from tests import ROOT
from tests.rows import rows

SEARCH = ROOT / "src" / "allanite" / "identification" / "search"


def numeric(value):
    """Whether an expression is a number, or holds one as it stands: not one that is called or made of names alone."""
    return any(isinstance(node, ast.Constant) and isinstance(node.value, int | float) for node in ast.walk(value))


def names(target):
    """The names that an assignment binds."""
    return [node.id for node in ast.walk(target) if isinstance(node, ast.Name)]


def constants(text):
    """The numeric constants of a module, and whether each is said: by a comment on its line or a text below it."""
    tree, lines = ast.parse(text), text.splitlines()
    for statement, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(statement, ast.Assign):
            bound, value = [name for target in statement.targets for name in names(target)], statement.value
        elif isinstance(statement, ast.AnnAssign):
            bound, value = names(statement.target), statement.value
        else:
            continue
        if value is not None and all(name.isupper() for name in bound) and numeric(value):
            yield ", ".join(bound), is_said(after) or "  # " in lines[statement.end_lineno - 1]


def is_said(after):
    return isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str)


def test_a_number_without_a_word_is_noticed():
    text = 'LOW = 2.0\nHIGH = 3\n"""Hz, at most."""\nROW = NAMES\nA, B = 1, 2\nSIDE = 4  # Hz, at most\n'
    assert dict(constants(text)) == {"LOW": False, "HIGH": True, "A, B": False, "SIDE": True}


@rows("path", sorted(SEARCH.glob("*.py")), ids=lambda path: path.stem)
def test_every_number_says_what_it_bounds(path):
    silent = [name for name, is_clear in constants(path.read_text("utf-8")) if not is_clear]
    assert silent == [], "say of each what it bounds, its unit and its source"


def test_there_are_numbers():
    assert sum(1 for path in SEARCH.glob("*.py") for _ in constants(path.read_text("utf-8"))) > 30
