"""The contents of a MATLAB 5 file, read with scipy.io.loadmat; started by `worker`.

Source of the format: MATLAB MAT-File Format (The MathWorks, 2024), chapter 1.
"""

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.io import loadmat

_NOT_VARIABLES = ("__header__", "__version__", "__globals__", "__function_workspace__")


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The numeric arrays and the fields of structures, and a function that sends them; see `worker.main`."""
    # The fields of an array of several structures are name/1/field, name/2/field. Cells, texts, truth values, complex
    # and sparse arrays, functions and objects of classes are omitted.
    contents: dict[str, Any] = {"datasets": [], "numbers": {}, "texts": {}, "left": [], "description": ""}
    with warnings.catch_warnings(record=True, action="always") as doubts:  # whatever is asked of the process
        arrays = dict(_variables(path, mat_dtype=True))
    if any(issubclass(doubt.category, np.exceptions.ComplexWarning) for doubt in doubts):
        # distinguished by the types in which they are stored, since loadmat drops imaginary parts
        stored = _variables(path, mat_dtype=False)
        arrays |= {where: leaf for where, leaf in stored if np.iscomplexobj(leaf)}
    for where, leaf in arrays.items():
        if type(leaf) is not np.ndarray or leaf.dtype.kind not in "iufU":
            contents["left"].append(where)
        elif leaf.dtype.kind == "U":
            if where == names["text"] and leaf.size == 1:
                contents["description"] = str(leaf[0])
        elif leaf.size == 1:
            contents["numbers"][where] = float(leaf.item())
        else:
            shape = (max(leaf.shape),) if leaf.ndim == 2 and min(leaf.shape) == 1 else leaf.shape
            contents["datasets"].append({"path": where, "shape": shape, "fields": [["", leaf.dtype.str, ()]]})
    return contents, lambda where, fields: (arrays[where].nbytes, [np.ascontiguousarray(arrays[where]).data])


def _variables(path: str, *, mat_dtype: bool) -> Iterator[tuple[str, Any]]:
    """The arrays of all variables, each with its path."""
    for name, value in loadmat(path, mat_dtype=mat_dtype, appendmat=False).items():
        if name not in _NOT_VARIABLES:
            yield from _leaves(name, value)


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """The arrays in a structure, each with its path."""
    if type(value) is not np.ndarray or not value.dtype.names:
        yield path, value
        return
    for i, element in enumerate(value.ravel(order="F"), 1):
        before = f"{path}/{i}" if math.prod(value.shape) > 1 else path
        for name in value.dtype.names:
            yield from _leaves(f"{before}/{name}", element[name])
