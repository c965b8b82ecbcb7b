"""The likelihood of a spectrum: expected powers of its bins by term, and what is known only to a factor in each.

Of flicker's correlation the transform leaves a factor of k alone, and quantization has a closed edge term (`terms.py`).
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import scipy

from allanite.core.arrays import BoolArray, FloatArray
from allanite.terms import TERMS, NoiseTerm

from .filters import FILTERS
from .likelihood import Likelihood
from .spectrum import SINGLE, BinnedSpectrum

LEAST_GAIN = 1e-10
"""Gain of a filter, at least, power over power: so low that it never takes part (1e-6 did behind a digital filter)."""

Pair = tuple[FloatArray, FloatArray]
"""Coefficients of a direction, of even and of odd index, shape (bins,) each; or products of directions."""


def likelihood(spectrum: BinnedSpectrum, symbols: Sequence[str]) -> Likelihood:
    """The likelihood of a spectrum for the terms `symbols` (keys of `TERMS`); deterministic ones are integrated out."""
    noise = [symbol for symbol in symbols if TERMS[symbol].waveform is None]
    with_ramp = len(noise) < len(symbols)
    UU, Uc = directions_of(spectrum, with_ramp)
    edge = np.array([TERMS[symbol].edge + TERMS[symbol].ends for symbol in noise])
    ends = 2 if spectrum.pieces is None else 0
    return Likelihood(
        S=np.column_stack([np.zeros((spectrum.first.size, 0)), *(table_column(symbol, spectrum) for symbol in noise)]),
        power=spectrum.power, count=spectrum.told, UU=UU, Uc=Uc, W=np.outer(np.arange(UU.shape[1]) < ends, 2 * edge),
        flat=np.arange(UU.shape[1]) >= ends,
    )  # fmt: skip


def with_warm_up(part: Likelihood, spectrum: BinnedSpectrum, used: BoolArray, tau: float) -> Likelihood:
    """A likelihood of the bins `used` with one more loose direction: a warm-up exp(-t / tau) of any size."""
    # Tau is in samples. The direction stands behind the edges and before the ramp.
    UU, Uc = directions_of(spectrum, bool(part.flat.any()), [warm_up_direction(spectrum, tau)])
    at = np.count_nonzero(~part.flat)
    wider = replace(part, count=spectrum.told[used], UU=UU[used], Uc=Uc[used], W=np.insert(part.W, at, 0.0, axis=0),
                    flat=np.insert(part.flat, at, True))  # fmt: skip
    return wider.trusted(part.count / wider.count)


def warm_up_direction(spectrum: BinnedSpectrum, tau: float) -> Pair:
    """The coefficients of exp(-t / tau), t and tau in samples."""
    if spectrum.times.size:  # with gaps, of the lowest bins only
        # the lowest coefficients of what is smooth, from its values in the middles of equal blocks of n samples
        values = np.exp(-spectrum.times / tau)
        lowest = np.asarray(scipy.fft.dct(values, norm="ortho")[1 : SINGLE + 1])
        return in_bins(spectrum, lowest * math.sqrt(spectrum.size / values.size))
    remaining = math.exp(-spectrum.size / tau)
    smooth = decay_coefficients(spectrum.first + (spectrum.count - 1) / 2, spectrum.size, tau)
    return smooth * (1 - remaining), smooth * (1 + remaining)


ASIDE = 1e-5  # number of coefficients by which a frequency that is that of a coefficient is moved, as 0/0 stands there


def wave_directions(spectrum: BinnedSpectrum, cycles: float) -> tuple[Pair, Pair]:
    """The coefficients of a cosine and a sine about the middle of the record, of so many periods in it."""
    n = spectrum.size
    if spectrum.times.size:  # with gaps, as a warm-up
        middle = (spectrum.times[0] + spectrum.times[-1]) / 2
        phase = 2 * math.pi * cycles / n * (spectrum.times - middle)
        lowest = scipy.fft.dct(np.array((np.cos(phase), np.sin(phase))), norm="ortho")[:, 1 : SINGLE + 1]
        cosine, sine = lowest * math.sqrt(n / phase.size)
        return in_bins(spectrum, cosine), in_bins(spectrum, sine)
    k = spectrum.first + (spectrum.count - 1) / 2
    near = float(2 * cycles - k[np.abs(2 * cycles - k).argmin()])
    turn = (math.pi * cycles + math.pi / 2 * (math.copysign(ASIDE, near) - near) * (abs(near) < ASIDE)) / n
    half = math.pi / (2 * n) * k
    smooth = math.sqrt(2 / n) * math.sin(turn) * np.cos(half) / (np.sin(turn + half) * np.sin(turn - half))
    zero = np.zeros_like(smooth)
    return (smooth * math.sin(turn * n), zero), (zero, smooth * math.cos(turn * n))


def directions_of(spectrum: BinnedSpectrum, with_ramp: bool, more: Sequence[Pair] = ()) -> Pair:
    """Products of the loose directions: both halves of the first sample, a warm-up, steps at long gaps, the ramp."""
    # The first sample has the coefficients a_k = sqrt(2/n) cos(pi k / 2n), the last one (-1)^k a_k; their even and odd
    # halves are what is orthogonal. Within a bin a_k hardly changes. The ramp needs the lowest bins only, one
    # coefficient each; without gaps only the odd ones are not zero.
    centre = spectrum.first + (spectrum.count - 1) / 2
    odd = (spectrum.first + spectrum.count) // 2 - spectrum.first // 2
    a = np.sqrt(2 / spectrum.size) * np.cos(np.pi / (2 * spectrum.size) * centre)
    pairs = [(a, 0 * a), (0 * a, a)] if spectrum.pieces is None else []
    pairs += more
    if with_ramp:
        pairs += [in_bins(spectrum, step_coefficients(spectrum.size, j)) for j in spectrum.steps.tolist()]
        pairs.append(in_bins(spectrum, spectrum.ramp))
    D = np.array(pairs).reshape(-1, 2, centre.size)  # shape (directions, 2, bins)
    trust = spectrum.told / spectrum.count
    count, sums = trust * np.stack((spectrum.count - odd, odd)), trust * np.stack((spectrum.even, spectrum.odd))
    return np.einsum("ipb,jpb,pb->bij", D, D, count), np.einsum("ipb,pb->bi", D, sums)


def step_coefficients(n: int, at: npt.ArrayLike) -> FloatArray:
    """The lowest coefficients of 0 before a sample and 1 from it on, for each sample of `at` along the last axis."""
    half = 0.5 * math.pi / n * np.arange(1, min(SINGLE, n - 1) + 1)
    return np.asarray(np.sin(np.multiply.outer(at, 2 * half)) * (-math.sqrt(0.5 / n) / np.sin(half)))


def step_products(spectrum: BinnedSpectrum, at: Sequence[float]) -> FloatArray:
    """Mean products of each two steps of size 1 in the bins, shape (steps * steps, bins).

    Of bins above the lowest coefficients, where their signs alternate within a bin.
    """
    # The coefficients of steps at i and j have the product [cos(pi k (i - j) / n) - cos(pi k (i + j) / n)] / (4 n
    # sin^2(pi k / 2n)). Within a bin the sine hardly changes, and the mean of a cosine is Dirichlet's kernel.
    n, centre = spectrum.size, spectrum.first + (spectrum.count - 1) / 2
    half = np.pi / (2 * n) * np.array((np.subtract.outer(at, at), np.add.outer(at, at)))[..., None]
    wide = np.sinc(half * spectrum.count / np.pi) / np.sinc(half / np.pi) * np.cos(2 * half * centre)
    mean = (wide[0] - wide[1]) / (4 * n * np.sin(np.pi * centre / (2 * n)) ** 2)
    return np.where(spectrum.first > SINGLE, mean, 0.0).reshape(-1, centre.size)


def in_bins(spectrum: BinnedSpectrum, lowest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The lowest coefficients of a direction in the bins, those of even and those of odd index."""
    d = np.zeros(spectrum.first.size)
    lowest = lowest[: spectrum.pieces.low] if spectrum.pieces else lowest
    d[: lowest.size] = lowest
    return d * (spectrum.first % 2 == 0), d * (spectrum.first % 2)


def decay_coefficients(k: FloatArray, n: int, tau: float) -> FloatArray:
    """DCT-II coefficients (orthonormal) of exp(-j / tau), j = 0..n-1, except for a factor 1 - (-1)^k exp(-n / tau)."""
    half, lost = (0.5 * math.pi / n) * k, -math.expm1(-1 / tau)
    return np.asarray(math.sqrt(2 / n) * np.cos(half) * lost / (lost**2 + 4 * (1 - lost) * np.sin(half) ** 2))


def column(row: NoiseTerm, spectrum: BinnedSpectrum) -> FloatArray:
    """Mean of a term's row over each bin, shape (bins,)."""
    nodes, weights, starts = spectrum.nodes
    how = spectrum.pieces
    each = spectrum.joints.row(row, nodes) if how is None else how.row(row, spectrum.joints, nodes)
    mean = np.add.reduceat(weights * each, starts) / spectrum.count
    if how is not None:
        mean[how.low :] = how.upper(row, mean)[how.low :]
    return np.asarray(mean)


def table_column(symbol: str, spectrum: BinnedSpectrum) -> FloatArray:
    """The same of a row of `TERMS`; it is made once."""
    if symbol not in spectrum.known:
        spectrum.known[symbol] = column(TERMS[symbol], spectrum)
    return spectrum.known[symbol]


def gain_of(row: str, cutoff: float, spectrum: BinnedSpectrum) -> FloatArray:
    """Mean power that a filter lets pass in each bin, shape (bins,); the cut-off in cycles a sample."""
    nodes, weights, starts = spectrum.nodes
    power = FILTERS[row].gain(nodes / (2 * spectrum.size), cutoff)
    return np.maximum(np.add.reduceat(weights * power, starts) / spectrum.count, LEAST_GAIN)
