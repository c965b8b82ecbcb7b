"""Names for packages that build on allanite, as its own applications do.

Names are imported when they are first used; ``__init__.pyi`` says where each of them is.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))

_WHERE = {alias.name: node.module for node in _STUB.body if isinstance(node, ast.ImportFrom) for alias in node.names}

__all__ = sorted(_WHERE)  # noqa: PLE0605 - the names of the stub


def __getattr__(name: str) -> Any:
    """What the stub names."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_WHERE[name]), name)
    return value
