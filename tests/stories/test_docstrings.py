"""Examples in docstrings run, and everything public has a docstring."""

import doctest
import importlib
import inspect
from pathlib import Path

import pytest

import allanite

SOURCE = Path(allanite.__file__).parent
MODULES = [
    ".".join(("allanite", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(".__init__")
    for path in sorted(SOURCE.rglob("*.py"))
    if ">>> " in path.read_text("utf-8")
]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name):
    module = importlib.import_module(name)
    namespace = vars(module) | {"np": importlib.import_module("numpy")}
    failed, tried = doctest.testmod(module, extraglobs=namespace, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert (failed, tried > 0) == (0, True)


@pytest.mark.parametrize("name", [n for n in dir(allanite) if not n.startswith("_") and callable(getattr(allanite, n))])
def test_public_things_are_documented(name):
    assert inspect.getdoc(getattr(allanite, name))
