"""What people look at: the terminal table, the figures, the page. Heavy libraries are imported when first used."""

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from allanite.comparison.comparison import Comparison
    from allanite.comparison.pooled import Pool
    from allanite.core.fit import Fit
    from allanite.study.analysis import Study
    from allanite.study.survey import Survey

PathLike = str | os.PathLike[str]


def plot(
    value: Any, fit: "Fit | None" = None, *, path: PathLike | None = None, level: float = 0.95, force: bool = False
) -> "Figure":
    """Draw a result for print.

    Parameters
    ----------
    value : Curve, Spectrum, Surface, Residuals, Fit, Channel, Study, Survey, Comparison, Pool, StateSpace, or several
        Deviation against averaging time, with confidence band, model and terms; several curves without fits share a
        panel. Density against frequency. Or the curves of all windows, and what changes with time. Of a state space,
        its curve beside the model's; a measured curve behind it in a sequence is drawn too.
    fit : Fit, optional
        What is drawn over a curve or spectrum, or over several statistics of one channel.
    path : path, optional
        Where the figure is saved; the suffix (.png, .svg, .pdf) says how.
    level : float
        Of the confidence band.
    force : bool
        Overwrite an existing file.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    UsageError
        There is nothing to draw; the file exists, its suffix is unknown, or its folder cannot be written.
    """
    from .drawings import draw
    from .style import demand_figure_path, save

    if path is not None:
        demand_figure_path(path, force=force)
    figure = draw(value, fit, level)
    if path is not None:
        save(figure, path, force=force)
    return figure


def report(study: "Study | Comparison | Pool", path: PathLike, *, force: bool = False) -> None:
    """Write a study, a comparison or a pool as one self-contained HTML file: numbers, figures, how they came about.

    Parameters
    ----------
    study : Study, Comparison or Pool
    path : path
        The file to write.
    force : bool
        Overwrite an existing file.

    Raises
    ------
    UsageError
        The file exists, or its folder cannot be written.
    """
    from allanite.core.files import demand_writable, write

    from .pages import page

    demand_writable(path, force=force)
    write(path, page(study).encode(), force=force)


def table(value: "Study | Survey | Comparison | Pool", *, width: int = 120, color: bool = False) -> str:
    """The result as text for a terminal of `width` columns; with `color`, ANSI codes in it."""
    from allanite.comparison.comparison import Comparison
    from allanite.comparison.pooled import Pool
    from allanite.reporting.comparison import text as compared
    from allanite.study.survey import Survey

    from . import listing, text

    if isinstance(value, (Comparison, Pool)):
        return compared.render(value, width=width, color=color)
    if isinstance(value, Survey):
        return listing.render(value, width=width, color=color)
    return text.render(value, width=width, color=color)
