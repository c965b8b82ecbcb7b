"""Examples in docstrings run, and everything public has a docstring."""

import doctest
import importlib
import inspect
from functools import partial
from pathlib import Path

from tests.rows import rows

import allanite

SOURCE = Path(allanite.__file__).parent
MODULES = [
    ".".join(("allanite", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(".__init__")
    for path in sorted(SOURCE.rglob("*.py"))
    if ">>> " in path.read_text("utf-8")
]


@rows("name", MODULES)
def test_examples(name):
    module = importlib.import_module(name)
    namespace = vars(module) | {"np": importlib.import_module("numpy")}
    failed, tried = doctest.testmod(module, extraglobs=namespace, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert (failed, tried > 0) == (0, True)


PLACES = (allanite, *map(partial(getattr, allanite), ("angle", "attitude", "compensation", "constant_rate", "faults")))
CLASSES = {
    thing.__name__: thing
    for place in PLACES
    for thing in (getattr(place, name) for name in dir(place) if not name.startswith("_"))
    if inspect.isclass(thing) and thing.__module__.startswith("allanite.") and not issubclass(thing, Exception)
}


@rows("name", CLASSES)
def test_a_public_class_lists_its_attributes(name):
    assert "Attributes\n----------" in inspect.getdoc(CLASSES[name])


@rows("name", [n for n in dir(allanite) if callable(getattr(allanite, n)) and not n.startswith("_")])
def test_examples_of_public_things_import_from_the_package_alone(name):
    imports = [line for line in inspect.getdoc(getattr(allanite, name)).splitlines() if "import" in line]
    assert not [line for line in imports if ">>> from allanite." in line or ">>> from ." in line]
