"""Examples in docstrings run, and everything public has a docstring."""

import doctest
import importlib
import inspect
import pkgutil

import pytest

import allanite

MODULES = [m.name for m in pkgutil.walk_packages(allanite.__path__, "allanite.") if not m.name.endswith("__main__")]


@pytest.mark.parametrize("name", ["allanite", *MODULES])
def test_examples(name):
    module = importlib.import_module(name)
    namespace = vars(module) | {"np": importlib.import_module("numpy")}
    failed, _ = doctest.testmod(module, extraglobs=namespace, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


@pytest.mark.parametrize("name", [n for n in dir(allanite) if not n.startswith("_") and callable(getattr(allanite, n))])
def test_public_things_are_documented(name):
    assert inspect.getdoc(getattr(allanite, name))
