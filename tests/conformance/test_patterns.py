"""Every regular expression of the package takes linear time of hostile characters, in each way that it is used.

A pattern that backtracks takes the square or the cube of the length: minutes for a unit that is filled with blanks.
The patterns are found in the source, with the methods that each is called by.
"""

import ast
import contextlib
import importlib
import re
import signal
from pathlib import Path

import pytest

import allanite

SOURCE = Path(allanite.__file__).parent
LENGTH = 100_000  # characters for which a linear pattern takes at most 0.2 s, a quadratic one minutes
SECONDS = 60  # of the processor, not of a clock
METHODS = ("search", "match", "fullmatch", "sub", "split", "findall", "finditer")
PIECES = (
    " ", "a", "A", "0", "(", "[", "<g", "\n", "_", ".", "-", "e1", "a ", "(a", "a (", "1.", "aB", "é", "темпер", "s*",
    '"', "'", "$A",
)  # fmt: skip


def constant(node):
    """The text of a literal, also of an f-string's or a concatenation's own letters; None for what is no text."""
    try:
        return ast.literal_eval(node)
    except ValueError:
        return None


def called(tree):
    """(name or pattern, method) of each call of a method of a pattern in a module."""
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in METHODS):
            continue
        owner = node.func.value
        if isinstance(owner, ast.Name) and owner.id == "re":
            pattern = constant(node.args[0])
            flags = {name.attr for k in node.keywords for name in ast.walk(k.value) if isinstance(name, ast.Attribute)}
            if isinstance(pattern, (str, bytes)):
                yield re.compile(pattern, sum(getattr(re, flag) for flag in flags)), node.func.attr
        elif isinstance(owner, ast.Name | ast.Attribute):
            yield owner.id if isinstance(owner, ast.Name) else owner.attr, node.func.attr


def within(value, name):
    """(name, pattern) of each pattern that a value holds: the name of the value, or of a field in it."""
    named = "_fields" if isinstance(value, tuple) else "__dataclass_fields__"
    fields = () if isinstance(value, type) else getattr(value, named, ())
    if isinstance(value, re.Pattern):
        yield name, value
    elif fields:
        for field in fields:
            yield from within(getattr(value, field, None), field)
    elif isinstance(value, dict | list | tuple):
        for part in value.values() if isinstance(value, dict) else value:
            yield from within(part, name)


def used():
    """{(pattern, method): place}: every pattern of the package in every way that it is used."""
    found, calls, held = {}, {}, []
    for path in sorted(SOURCE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "re." not in text:
            continue
        place = ".".join(path.relative_to(SOURCE).with_suffix("").parts)
        for what, method in called(ast.parse(text)):
            if isinstance(what, re.Pattern):
                found.setdefault((what, method), place)
            else:
                for where in (place, ""):
                    calls.setdefault((where, what), {})[method] = None  # a set in order: workers collect the same tests
        if "re.compile" in text:
            with contextlib.suppress(ModuleNotFoundError):  # the library of an extra
                values = vars(importlib.import_module(f"allanite.{place}"))
                held += [(place, *pair) for name, value in values.items() for pair in within(value, name)]
    for place, name, pattern in held:
        for method in calls.get((place, name)) or calls.get(("", name)) or METHODS:
            found.setdefault((pattern, method), f"{place}:{name}")
    return found


def apply(pattern, method, text):
    if method == "sub":
        pattern.sub(b"" if isinstance(text, bytes) else "", text)
    else:
        result = getattr(pattern, method)(text)
        if method == "finditer":
            list(result)


def texts(pattern):
    """Texts that repeat a piece: those of every list of attacks, and what the pattern itself looks for."""
    source = pattern.pattern if isinstance(pattern.pattern, str) else pattern.pattern.decode("latin-1")
    for piece in dict.fromkeys((*PIECES, *re.findall(r"\w{2,}|[^\w\s\\]", source))):
        text = (piece * (LENGTH // len(piece) + 1))[: LENGTH - 1] + "\x01"
        yield text if isinstance(pattern.pattern, str) else text.encode("utf-8", "ignore")


def late(*_):
    raise TimeoutError


@pytest.fixture
def limited():
    """A call ends with an error if it takes too long."""
    before = signal.signal(signal.SIGVTALRM, late)
    yield
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    signal.signal(signal.SIGVTALRM, before)


@pytest.mark.nightly("every pattern with every hostile text")
@pytest.mark.usefixtures("limited")
def test_it_takes_linear_time(subtests):
    for (pattern, method), place in used().items():
        with subtests.test(place):
            for text in texts(pattern):
                signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
                try:
                    apply(pattern, method, text)
                except TimeoutError:
                    pytest.fail(
                        f"{pattern.pattern!r}.{method} takes longer than {SECONDS} s for text like {text[:12]!r}"
                    )
