"""Examples in docstrings run, and everything public has a docstring."""

import doctest
import importlib
import inspect
import re
from pathlib import Path

import pytest
from tests.rows import rows

import allanite

SOURCE = Path(allanite.__file__).parent
MODULES = [
    ".".join(("allanite", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(".__init__")
    for path in sorted(SOURCE.rglob("*.py"))
    if ">>> " in path.read_text("utf-8")
]


@pytest.mark.slow("examples of all modules")
@rows("name", MODULES)
def test_examples(name):
    module = importlib.import_module(name)
    namespace = vars(module) | {"np": importlib.import_module("numpy")}
    failed, tried = doctest.testmod(module, extraglobs=namespace, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert (failed, tried > 0) == (0, True)


INTERNAL = re.split(r"(?m)^(allanite\..*)$", Path(__file__).with_name("internal_examples.txt").read_text("utf-8"))[1:]


@rows("name, text", zip(INTERNAL[::2], INTERNAL[1::2], strict=True))
def test_examples_of_internal_functions(name, text):
    namespace = vars(importlib.import_module(name)) | {"np": importlib.import_module("numpy")}
    example = doctest.DocTestParser().get_doctest(text, namespace, name, None, None)
    assert doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(example).failed == 0


def public(place):
    return {name: getattr(place, name) for name in dir(place) if not name.startswith("_")}


def test_a_public_class_lists_its_attributes():
    packages = ("angle", "attitude", "compensation", "constant_rate", "faults")
    things = [thing for place in (allanite, *(getattr(allanite, name) for name in packages))
              for thing in public(place).values() if inspect.isclass(thing)]  # fmt: skip
    own = {thing for thing in things if thing.__module__.startswith("allanite.") and not issubclass(thing, Exception)}
    assert len(own) > 50
    assert [thing.__name__ for thing in own if "Attributes\n----------" not in inspect.getdoc(thing)] == []


def test_examples_of_public_things_import_from_the_package_alone():
    texts = {name: inspect.getdoc(thing) for name, thing in public(allanite).items() if callable(thing)}
    assert [name for name, text in texts.items() if re.search(r">>> from (allanite)?\..* import", text)] == []
