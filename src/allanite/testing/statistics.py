"""A statistic against itself: its sums, its windows, their number, and what it leaves out."""

import numpy as np

from allanite.core.aliases import public
from allanite.core.constructors import N
from allanite.core.record import Record
from allanite.simulation.record import simulate
from allanite.statistics import STATISTICS, deviation, expected
from allanite.statistics.row import Statistic

SIZE = 240
FACTORS = (1, 2, 4, 8)
RECORDS = 60


@public
def check_statistic(row: Statistic) -> None:
    """Check that a row of `STATISTICS` keeps what it says.

    It is described; windows fit up to its largest averaging factor; its sums are those of its windows, and 0 of a
    polynomial below its order; and its mean over simulated records is what is expected of white noise.

    Raises
    ------
    AssertionError
        It does not: ``statistic 'mydev': sums at m = 4 are 2.1, but those of its windows 1.05``.

    Examples
    --------
    >>> from allanite import STATISTICS
    >>> check_statistic(STATISTICS["hdev"])
    """
    about = f"statistic {row.name!r}:"
    for text in ("name", "title", "formula", "reference", "meaning", "use", "limits", "cost"):
        assert getattr(row, text), f"{about} {text} is empty"
    if row.parts:
        return  # they have rows of their own
    most = row.largest(SIZE)
    assert most > 0, f"{about} no averaging factor fits in {SIZE} intervals"
    m = np.array([factor * row.step for factor in FACTORS if factor * row.step <= most])
    assert np.all(row.count(SIZE, m) > 0), f"{about} no window fits at averaging factors up to the largest"
    x = np.concatenate(([0.0], np.cumsum(np.random.default_rng(1).standard_normal(SIZE))))
    sums = row.sums(x, m)
    line = np.arange(SIZE + 1.0) ** (row.order - 1)
    left = np.abs(row.sums(line, m)) / (np.abs(line).max() ** 2 * row.count(SIZE, m))
    assert np.all(left < 1e-12), f"{about} order is {row.order}, but t^{row.order - 1} is not left out"
    if row.window is not None and row.span[0] and not row.extreme:
        for factor, total in zip(m.tolist(), sums, strict=True):
            of_windows = _by_windows(row, x, factor)
            assert np.isclose(total, of_windows, rtol=1e-8), (
                f"{about} sums at m = {factor} are {total:.12g}, but those of its windows {of_windows:.12g}"
            )
        if row.order > 1:  # the others have no intervals
            _check_mean(row, m, about)


def _by_windows(row: Statistic, x: "np.ndarray[tuple[int], np.dtype[np.float64]]", m: int) -> float:
    """The sum of squares over the windows of x, as the row defines one."""
    assert row.window is not None
    weights, filters = row.window(m)
    every = np.lib.stride_tricks.sliding_window_view(x, filters.shape[1])[:: 1 if row.overlapped else m]
    of_each = (every @ filters.T) ** 2 @ weights
    return float(of_each[: int(row.count(x.size - 1, np.array([m]))[0])].sum())


def _check_mean(row: Statistic, m: "np.ndarray[tuple[int], np.dtype[np.int64]]", about: str) -> None:
    """Compare the mean over simulated records with the expectation."""
    with STATISTICS.trying(row.name, row):
        model, rng = N(1.0, "rad/sqrt(s)"), np.random.default_rng(2)
        records = [Record(simulate(model, SIZE, 1.0, rng=rng).values, 1.0, "rad/s") for _ in range(RECORDS)]
        curves = [deviation(record, row.name, m=m.tolist(), noise=model) for record in records]
        mean = np.mean([curve.variance for curve in curves], axis=0)
        exact = expected(model, row.name, curves[0].tau, rate=1.0, size=SIZE)
    off = (mean / exact - 1) / np.sqrt(2 / (np.array(curves[0].edf) * RECORDS))
    assert np.all(np.abs(off) < 5), (
        f"{about} the mean over {RECORDS} records of white noise is {mean / exact} of what is expected, "
        f"{np.abs(off).max():.0f} standard errors away"
    )
