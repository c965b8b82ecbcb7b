"""Every number of the search is said: what it bounds, its unit, and where it comes from."""

import ast

from tests import ROOT

SEARCH = ROOT / "src" / "allanite" / "identification" / "search"


def constants(text):
    """The numeric constants of a module, and whether each is said: by a comment on its line or a text below it."""
    tree, lines = ast.parse(text), text.splitlines()
    for statement, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(statement, ast.Assign | ast.AnnAssign):
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            bound = [node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)]
            if statement.value is not None and all(name.isupper() for name in bound) and numeric(statement.value):
                is_said = isinstance(after, ast.Expr) and isinstance(getattr(after.value, "value", None), str)
                yield ", ".join(bound), is_said or "  # " in lines[statement.end_lineno - 1]


def numeric(value):
    """Whether an expression is a number, or holds one as it stands: not one that is called or made of names alone."""
    return any(isinstance(node, ast.Constant) and isinstance(node.value, int | float) for node in ast.walk(value))


def test_a_number_without_a_word_is_noticed():
    text = 'LOW = 2.0\nHIGH = 3\n"""Hz, at most."""\nROW = NAMES\nA, B = 1, 2\nSIDE = 4  # Hz, at most\n'
    assert dict(constants(text)) == {"LOW": False, "HIGH": True, "A, B": False, "SIDE": True}


def test_every_number_says_what_it_bounds():
    every = [
        (path.stem, *named) for path in sorted(SEARCH.glob("*.py")) for named in constants(path.read_text("utf-8"))
    ]
    assert len(every) > 30
    silent = [named for *named, is_clear in every if not is_clear]
    assert silent == [], "say of each what it bounds, its unit and its source"
