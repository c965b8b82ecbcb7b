"""Correlations between channels beyond their models: vibration, temperature, supply voltage."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.record import Recording
from allanite.core.residuals import Shared
from allanite.core.validity import Finding
from allanite.parallel.processes import spread
from allanite.phrases.phrase import Phrase, say, say_count
from allanite.prepare.outliers import demand_choice, treated

from .whitening import whitened

STRETCHES = 64  # parts of the record over which slow residuals are averaged
SIGMAS, MATTERS = 5.0, 0.05  # standard errors, and size, above which a correlation is reported


@public
def shared(recording: Recording, fits: Mapping[str, Fit], *, outliers: str = "mark", threads: int = 1) -> Shared:
    """Correlations between the residuals of channels, which separate models of the channels cannot describe.

    Parameters
    ----------
    recording : Recording
    fits : name of a channel -> Fit
        At least two, as returned by ``identify(recording)``.
    outliers : {"mark", "keep"}
        How the fits treated outliers.
    threads : int
        Channels that are processed at once; the result is the same.

    Returns
    -------
    Shared
        "fast", of all samples, with standard error 1/sqrt(n); and "slow", of means over 64 stretches of the record,
        with standard error 1/8, which shows common effects over minutes and hours, such as temperature.

    Raises
    ------
    UsageError
        There are fewer than two fits, or their channels differ in length.

    Examples
    --------
    >>> from allanite import N, Record, identify
    >>> noise = np.random.default_rng(1).standard_normal((3, 20_000))
    >>> channels = [Record(noise[i] + noise[2], 100.0, "deg/s", name=name) for i, name in enumerate("xy")]
    >>> recording = Recording(tuple(channels))
    >>> found = shared(recording, identify(recording))
    >>> round(float(found.fast[0, 1]), 1), [finding.name for finding in found.findings]
    (0.5, ['shared'])
    """
    demand_choice(outliers)
    names = [name for name in recording.channels if name in fits]
    if len(names) < 2 or len({recording[name].size for name in names}) > 1:
        raise UsageError(f"correlations need at least two channels of equal length, not {', '.join(names) or 'none'}")

    def left(name: str) -> NDArray[np.float32]:
        record = treated(recording[name], outliers)
        # missing samples are zero and do not contribute
        return np.nan_to_num(whitened(record, fits[name].model, fits[name].scope), copy=False)

    series = spread(left, names, threads)
    bounds = np.linspace(0, series[0].size, STRETCHES + 1).astype(np.int64)[:-1]
    means = [np.add.reduceat(u, bounds, dtype=np.float64) for u in series]
    fast, slow = _correlations(series), _correlations(means)
    length = series[0].size / recording[names[0]].rate / STRETCHES
    pairs = (
        _finding(names, fast, series[0].size, say("sample by sample")),
        _finding(names, slow, STRETCHES, say("in means over {length:.3g} s", length=length)),
    )
    return Shared(tuple(names), fast, slow, tuple(filter(None, pairs)))


def _finding(names: Sequence[str], correlations: FloatArray, count: int, how: Phrase) -> Finding | None:
    """The pairs of channels with a significant correlation of so many values."""
    size = np.abs(np.triu(correlations, 1))
    z = np.arctanh(np.minimum(size, 0.999999)) * np.sqrt(count - 3)
    pairs = int(((size > MATTERS) & (z > SIGMAS)).sum())
    if not pairs:
        return None
    i, j = divmod(int(size.argmax()), len(names))
    what = say_count(pairs, "the residuals of {channel} and {other} are correlated {how} ({correlation:+.2g})",
                     "the residuals of {count} pairs of channels are correlated {how}, most of all those of "
                     "{channel} and {other} ({correlation:+.2g})",
                     channel=names[i], other=names[j], how=how, correlation=correlations[i, j])  # fmt: skip
    remedy = say("look for vibration, temperature, or a common supply, clock or reference")
    return Finding("shared", what, say("their noises are not independent"), remedy)


def _correlations(series: list[NDArray[np.float32]] | list[FloatArray]) -> FloatArray:
    products = np.array([[float(a @ b) for b in series] for a in series])
    size = np.sqrt(np.diag(products))
    return np.asarray(products / np.outer(size, size))
