"""Compiled inner loops: contiguous arrays and integers in, arrays out; no checks, no units, no values.

Slices are taken before the loops, so that no index needs a sign test and the compiler can use SIMD; sums are kept per
block and then added, which also keeps rounding errors from growing with the length. The modules of loops are imported
when one of their names is used: numba takes half a second.
"""

from importlib import import_module
from typing import Any


class Later:
    """A module that is imported when one of its names is used."""

    def __init__(self, path: str) -> None:
        self.__name__ = path

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # what is asked of any object
            raise AttributeError(name)
        return getattr(import_module(self.__name__), name)


_MODULES = ("allan", "cosine", "ladder", "leastsquares", "passing", "squared", "streamed", "summed", "theo", "total",
            "whittle")  # fmt: skip
globals().update({name: Later(f"{__name__}.{name}") for name in _MODULES})
