"""Which figure a value becomes."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from allanite.comparison.comparison import Comparison
from allanite.comparison.pooled import Pool
from allanite.core.curve import Curve
from allanite.core.fit import Fit
from allanite.core.residuals import Residuals
from allanite.core.spectrum import Spectrum
from allanite.core.surface import Surface
from allanite.reporting.comparison.figures import plot_comparison
from allanite.statespace import StateSpace
from allanite.study.survey import Survey

from .equivalent import plot_state_space
from .figures import plot_panels
from .overlay import plot_overlay
from .panels import Panel, panels_of
from .residuals import plot_residuals
from .spectra import plot_spectra
from .surfaces import plot_surfaces


def draw(value: Any, fit: Fit | None, level: float) -> Figure:
    """The figure of a value; see `allanite.plot`."""
    if isinstance(value, (Comparison, Pool)):
        return plot_comparison(value)
    items = _items(value)
    if items and isinstance(items[0], StateSpace):
        return plot_state_space(items[0], [item for item in items[1:] if isinstance(item, Curve)], level=level)
    if len(items) == 1 and isinstance(items[0], Residuals):
        return plot_residuals(items[0])
    return _of_a_kind(value, items, fit, level)


def _of_a_kind(value: Any, items: list[Any], fit: Fit | None, level: float) -> Figure:
    fits = value.fits if isinstance(value, Survey) else {}
    if items and all(isinstance(item, Spectrum) for item in items):
        return plot_spectra(items, fits or {item.name: fit for item in items if fit is not None}, level=level)
    if items and all(isinstance(item, Surface) for item in items):
        return plot_surfaces(items)
    if len(items) > 1 and all(isinstance(item, Curve) for item in items):
        return plot_overlay([Panel(item.name, item, fit) for item in items], level=level)
    return plot_panels(panels_of(items[0] if len(items) == 1 else value, fit), level=level)


def _items(value: Any) -> list[Any]:
    if isinstance(value, Survey):
        return list(value.values)
    return list(value) if isinstance(value, Sequence) and not isinstance(value, str) else [value]
