"""A kernel gives the same bits whatever was compiled or loaded before it: see `allanite.kernels.compiling`."""

import ast
import importlib
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher
from tests.rows import rows

import allanite
from allanite import kernels

HOMES = [
    importlib.import_module(f"{kernels.__name__}.{module.name}") for module in pkgutil.iter_modules(kernels.__path__)
]
KERNELS = {
    f"{home.__name__.rpartition('.')[2]}.{name}": value for home in HOMES for name, value in vars(home).items()
    if isinstance(value, Dispatcher) and value.py_func.__module__ == home.__name__
}  # fmt: skip


def called(kernel):
    """The kernels that a kernel names."""
    function = kernel.py_func
    named = (function.__globals__.get(name) for name in function.__code__.co_names)
    return [value for value in named if isinstance(value, Dispatcher)]


def reorders(kernel):
    """Whether sums of a kernel, or of one that it calls, may be reordered."""
    return bool(kernel.targetoptions.get("fastmath")) or any(map(reorders, called(kernel)))


@rows("name", KERNELS)
def test_parts_with_sums_in_any_order_are_inlined(name):
    for part in called(KERNELS[name]):
        options = part.targetoptions
        assert options.get("forceinline") or options.get("inline") or not reorders(part), part.py_func.__name__


def test_what_is_compiled_with_its_caller_has_one():
    once = [part for each in KERNELS.values() for part in called(each) if part.targetoptions.get("inline")]
    assert len(once) == len(set(once))


def imported():
    """(file, name) of what the rest of the package takes of the kernels."""
    for file in Path(allanite.__file__).parent.rglob("*.py"):
        if file.parent.name == "kernels":
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and "kernels." in (node.module or ""):
                yield from ((file.name, f"{node.module.rpartition('.')[2]}.{one.name}") for one in node.names)
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                yield file.name, f"{node.value.id}.{node.attr}"


@pytest.mark.slow("takes more than half a second")
def test_what_python_calls_has_a_wrapper():
    """Without one, the process ends."""
    names = [pair for pair in imported() if pair[1] in KERNELS]
    assert len(names) > 30
    assert [pair for pair in names if KERNELS[pair[1]].targetoptions.get("no_cpython_wrapper")] == []


PROGRAM = """
import numpy as np
from allanite.kernels.cosine import binned
c = np.random.default_rng(1).standard_normal(5000)
print(binned(c, np.array([0, 3, 10, 107, 1200, 5000])).tobytes().hex())
"""


@pytest.mark.slow("takes more than half a second")
def test_compiled_and_loaded_code_give_the_same_bits(tmp_path):
    command, environment = [sys.executable, "-c", PROGRAM], os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    first, again = (subprocess.run(command, env=environment, capture_output=True, check=True) for _ in range(2))
    assert first.stdout == again.stdout
    assert list(tmp_path.rglob("*.nbc"))
