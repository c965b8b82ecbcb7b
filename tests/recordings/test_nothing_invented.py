"""Every channel of the recordings: no claim that its own curve, its rounding or its spectrum contradicts."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import welch
from tests import thinned
from tests.recordings.test_every_recording import FILES
from tests.rows import rows

import allanite as al
from allanite.core.model import Model, Term
from allanite.prepare.rounding import grid
from allanite.statistics import expected
from allanite.terms import TERMS

pytestmark = pytest.mark.usefixtures("analyzed_once")

STILL = [file for file in FILES if file.code == 0 and not file.name.endswith(("compass.mat", ".imu", "idle.bag"))]
"""Inertial sensors at rest."""

FLAT, OUTSIDE, ROUNDED = 1.3, 1.5, 3.0
STRAIGHT, BESIDE = 0.1, 1.1
"""Difference of the slope from -1/2; other noise has then a fifth of the variance at most, a tenth of the deviation."""


def curve_of(channel):
    """The Allan deviation of a channel with its limits, SI."""
    curve = al.deviation(channel.record, "oadev", taus="octave", noise=channel.fit)
    return curve, *curve.interval(0.95)


def deviation_of(model, curve):
    return np.sqrt(expected(model, "oadev", curve.tau, rate=curve.rate, size=curve.size))


def above_the_curve(channel):
    """Claimed terms whose lower limit alone exceeds the upper limit of the curve."""
    curve, _, high = curve_of(channel)
    inside = channel.fit.scope.holds(curve.tau)
    noise = [e for e in channel.fit if e.claimed and TERMS[e.symbol].waveform is None]
    alone = {e.symbol: Model((Term(e.symbol, e.interval()[0], e.signal, e.shape),)) for e in noise if e.interval()[0]}
    ratio = {symbol: (deviation_of(model, curve) / high)[inside] for symbol, model in alone.items()}
    return {symbol: float(one.max()) for symbol, one in ratio.items() if one.size and one.max() > 1.05}


def beyond_rounding(channel):
    """Quantization noise over that of the step of the samples."""
    record, Q = channel.record, channel.fit["Q"]
    step = grid(record.values[np.isfinite(record.values)])[1] * record.factor
    angle = step if record.kind == "angle" else step / record.rate
    return Q.value / (angle / math.sqrt(12)) if Q.claimed and step else 0.0


def below_the_curve(channel):
    """What the curve shows at 1 s over the upper limit of N, where its slope is -1/2 and the model holds."""
    N, read = channel.fit["N"], channel.readings
    most = N.interval()[1] if N.claimed else N.upper
    shown = read.around is not None and channel.fit.scope.holds(np.array([read.usual.tau])).all()
    if not most or not shown or abs(read.around.value + 0.5) > STRAIGHT:
        return 0.0
    return read.usual.interval(0.99)[0] * math.sqrt(read.usual.tau) / most


def without_corner(channel):
    """Whether a filter is claimed where the median spectrum is flat from a quarter of its cut-off on."""
    scope, record = channel.fit.scope, channel.record
    if scope.filter is None or not channel.noise.explained:
        return False
    y = record.values[np.isfinite(record.values)]
    f, power = welch(y, record.rate, nperseg=min(4096, y.size // 8))
    ends = record.rate / 2 * 2.0 ** -np.arange(9.0)
    octaves = [power[(f >= low) & (f < high)] for high, low in pairwise(ends.tolist())
               if high > scope.filter.cutoff / 4]  # fmt: skip
    level = [np.median(one) for one in octaves if one.size > 3]
    # the top of a first-order roll-off is seen as its end, not as the median of an octave
    last = np.median(power[f > 2**-0.25 * record.rate / 2])
    chance = 2 * 1.25 * math.sqrt(2 * 2 / (0.16 * y.size))  # two standard errors of the ratio of two medians
    return max(level) / min(*level, last) < FLAT - chance


def outside_its_band(channel):
    """By how much the model leaves the limits of the curve where it is said to hold."""
    if not channel.noise.explained or channel.fit.valid is None:
        return 1.0
    curve, low, high = curve_of(channel)
    own, inside = deviation_of(channel.fit.complete(channel.fit.valid), curve), channel.fit.scope.holds(curve.tau)
    return float(np.maximum(own / high, low / own)[inside].max(initial=1.0))


@pytest.mark.slow("takes more than half a second")
@rows("file", thinned(STILL, 3, "every recording"), ids=lambda file: file.name)
def test_no_claim_is_contradicted(recordings, file):
    for channel in al.analyze(recordings / file.name, **file.options):
        if channel.noise is None:
            continue
        who = channel.record.name
        assert above_the_curve(channel) == {}, who
        assert beyond_rounding(channel) <= ROUNDED, who
        assert below_the_curve(channel) <= BESIDE, who
        assert not without_corner(channel), who
        assert outside_its_band(channel) <= OUTSIDE, who


@pytest.mark.slow("takes more than half a second")
def test_vibration_of_an_engine_is_no_noise_of_the_sensor(recordings):
    """A sinusoid at 10 Hz that was removed is not proposed again as a damped oscillation."""
    study = al.analyze(recordings / "vn100_car_idle.bag")
    assert [c.record.name for c in study for finding in c.fit.findings if finding.name == "terms"] == []
