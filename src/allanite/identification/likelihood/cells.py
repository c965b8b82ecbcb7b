"""Neighbouring bins, and cells of several of them, of a spectrum."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, IntArray

from .spectrum import BinnedSpectrum

CELLS = 24
"""Cells of equal width in the logarithm of frequency, in which observed and expected power are compared."""

WELL_KNOWN = 50
"""Coefficients of a bin, or of a cell, whose power needs no smoothing."""


def surroundings(values: NDArray[Any]) -> NDArray[Any]:
    """Nine neighbouring bins around each, at the ends the nine nearest, shape (bins, 9)."""
    windows = np.lib.stride_tricks.sliding_window_view(values, 9)
    return windows[np.clip(np.arange(values.size) - 4, 0, len(windows) - 1)]


def cell_of(spectrum: BinnedSpectrum, used: BoolArray) -> IntArray:
    """Cell of each bin, those that are not used included, shape (bins,)."""
    bounds = spectrum.first[used][[0, -1]]
    edges = np.geomspace(bounds[0], bounds[1] + 1, CELLS + 1)
    return np.asarray(np.clip(np.searchsorted(edges, spectrum.first, side="right") - 1, 0, CELLS - 1))
