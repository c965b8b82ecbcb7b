"""What a record has beside the terms, as findings: a warm-up, steps, another power law, vibration that hides noise."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.estimate import WEAK, Estimate
from allanite.core.fit import Line
from allanite.core.limits import NormalMixture, Remembered, quantile
from allanite.core.model import Term, coefficient_factor
from allanite.core.plain import Portable
from allanite.core.units import convert
from allanite.core.validity import Finding
from allanite.phrases.phrase import join, longest_without, say, spelled
from allanite.terms import TERMS

from .components import COMPONENTS, Part
from .estimates import Answer, profile_ends
from .fitting import Fitted, column_of_part, fitted
from .frame import DIRECTIONS
from .moves import PLACES

RESONANCES = COMPONENTS["resonance"].most
"""Vibrations in a record, at most: one that has so many is not described by them."""

HARMLESS = 2.0  # standard errors to which a warm-up has fallen where a window can begin
USABLE = 0.75  # share of the record that may be cut off
HIGHEST_RISE = 12.0  # rise of the value up to which time constants of a warm-up are looked at
TIME_CONSTANTS = 24  # time constants over which the size of a warm-up is averaged


def sizes_of(f: Fitted, name: str) -> tuple[FloatArray, FloatArray]:
    """Sizes of the loose directions of a component, and their standard errors, in the unit of the spectrum."""
    names = [p.name for p in f.state if p.name in DIRECTIONS for _ in f.frame.directions(p.name, p.shape[0])]
    eta, V, _ = f.trusted.directions(f.theta)
    at = int(np.count_nonzero(~f.trusted.flat)) + np.flatnonzero([n == name for n in names])
    return eta[at], np.sqrt(np.diag(V)[at])


@dataclass(frozen=True, eq=False)
class WarmUp(Portable):
    """A warm-up exp(-t / tau) of a fit."""

    answer: Answer
    f: Fitted

    @property
    def part(self) -> Part:
        """Its part."""
        return self.f.state.of("warm-up")[0]

    @property
    def tau(self) -> float:
        """Its time constant, s."""
        return self.part.shape[0] / self.answer.scale.rate

    @cached_property
    def size(self) -> tuple[float, float]:
        """Amplitude at the start and its standard error, SI."""
        amplitude, error = sizes_of(self.f, "warm-up")
        return float(amplitude[0]) * self.answer.scale.factor, float(error[0]) * self.answer.scale.factor

    @property
    def term(self) -> Term:
        """It as a term of a model."""
        return Term("W", -self.size[0], self.answer.scale.signal, (self.tau,))

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        spectrum = self.f.frame.spectrum
        return (spectrum.size + int(spectrum.gaps.lost.sum())) / spectrum.rate

    @property
    def until(self) -> float:
        """Seconds after which the remaining warm-up is negligible, rounded up to two digits."""
        amplitude, error = self.size
        needed = self.tau * math.log(max(abs(amplitude) / (HARMLESS * error), 1.1))
        step = 10.0 ** (math.floor(math.log10(needed)) - 1)
        return float(f"{math.ceil(needed / step) * step:.3g}")

    def at(self, tau: float) -> tuple[float, float, float]:
        """Value, amplitude and its standard error with another time constant, s."""
        part = self.part._replace(shape=(tau * self.answer.scale.rate,))
        f = fitted(self.f.frame, self.f.state.lacking(self.part).having(part), None, self.f, self.f.v)
        amplitude, error = sizes_of(f, "warm-up")
        return f.value, float(amplitude[0]) * self.answer.scale.factor, float(error[0]) * self.answer.scale.factor

    @property
    def finding(self) -> Finding:
        """The finding about the warm-up."""
        signal = self.answer.scale.signal
        unit = signal.sheet[0]
        size, error = (convert(value, signal.unit, unit) for value in self.size)
        usable, cut = self.until <= USABLE * self.duration, self.f.frame.spectrum.cut
        remedy = (
            say("cut it off ({option})",
                option=spelled(f"--from {cut + self.until:g}", f"prepare.trim(recording, {cut + self.until:g})"))
            if usable
            else (
                say("record again, starting at least {seconds:.3g} s after switching on: too little would remain if "
                    "it were cut off", seconds=self.until)
            )
        )  # fmt: skip
        return Finding(
            "warm-up",
            say("the sensor warms up: its bias starts {size:+.3g} ± {error:.2g} {unit} from where it settles, with "
                "a time constant of {tau:.3g} s", size=size, error=error, unit=unit, tau=self.tau),
            say("the coefficients are those of the noise without it; K and R are less certain"),
            remedy,
            (cut, cut + min(self.until, self.duration)),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class WarmUpProfile(Portable):
    """The profile of the value over the time constant of a warm-up."""

    warm: WarmUp

    def ends(self, drop: float) -> tuple[float, float]:
        """Time constants, s, at which the value has risen by `drop`; at most from a thousandth to all of the record."""
        middle, least = math.log(self.warm.tau), self.warm.at(self.warm.tau)[0]
        ends = []
        for end in (math.log(self.warm.duration / 1000), math.log(self.warm.duration)):

            def excess(x: float) -> float:
                return self.warm.at(math.exp(x))[0] - least - drop

            near = next((x for x in middle + (end - middle) * 2.0 ** np.arange(-9.0, 1.0) if excess(x) > 0), None)
            ends.append(math.exp(end if near is None else scipy.optimize.brentq(excess, middle, near, xtol=1e-4)))
        return ends[0], ends[1]

    def __call__(self, level: float) -> tuple[tuple[float, float], ...]:
        """Two-sided limits of the time constant, s."""
        return (self.ends(quantile((1 + level) / 2) ** 2),)

    @cached_property
    def size(self) -> NormalMixture:
        """The law of the size: normal at a time constant, averaged over these."""
        low, high = self.ends(HIGHEST_RISE)
        nodes = [self.warm.at(tau) for tau in np.geomspace(low, high, TIME_CONSTANTS).tolist()]
        excess, amplitude, error = np.array(nodes).T
        weight: FloatArray = np.exp(-0.5 * (excess - excess.min()))
        return NormalMixture(-amplitude, error, weight / weight.sum())


def warm_up_estimate(symbol: str, warm: WarmUp | None, answer: Answer) -> Estimate:
    """The change of the rate from the start of the record to where it settles; absent without a warm-up."""
    signal = answer.scale.signal
    if warm is None:
        return Estimate(symbol, signal, None, None, "absent", None, "whittle")
    along = WarmUpProfile(warm)
    law, value = along.size, -warm.size[0]
    error = law.error_of(value)
    status = "identified" if error <= WEAK * abs(value) else "weak"
    limits = Remembered(law)
    return Estimate(symbol, signal, value, error, status, law.upper(0.95), "whittle", limits, limits, value,
                    shape=(warm.tau,), shape_limits=Remembered(along))  # fmt: skip


def wave_of(answer: Answer, f: Fitted) -> Line:
    """The slow wave of a fit as a sinusoid."""
    spectrum, rate, factor = f.frame.spectrum, answer.scale.rate, answer.scale.factor
    turn = 2 * math.pi * f.state.of("wave")[0].shape[0] / spectrum.size  # radians a sample
    (cosine, sine), error = sizes_of(f, "wave")
    middle = (spectrum.times[0] + spectrum.times[-1] + 1) / 2 if spectrum.times.size else spectrum.size / 2
    phase = math.remainder(math.atan2(cosine, sine) - turn * middle, 2 * math.pi)
    frequency, size = turn * rate / (2 * math.pi), math.hypot(cosine, sine)
    return Line(frequency, size * factor, float(error.max()) * factor, phase, answer.scale.signal)


def wave_finding(wave: Line) -> Finding:
    """The finding about a slow wave."""
    return Finding(
        "wave",
        say("the bias follows a slow wave with a period of {period:.3g} s: {wave}", period=1 / wave.frequency,
            wave=wave.words()),
        say("the coefficients are those of the noise without it; B and K are less certain"),
        say("look for cycles of the temperature, or record for longer"),
    )  # fmt: skip


def steps_of(answer: Answer, f: Fitted) -> tuple[tuple[float, float], ...]:
    """Time in the record, s, and size, SI, of the steps of a fit."""
    size = sizes_of(f, "step")[0] * answer.scale.factor
    return tuple((p.shape[0] / answer.scale.rate, float(s)) for p, s in zip(f.state.of("step"), size, strict=True))


def steps_finding(answer: Answer, f: Fitted, steps: tuple[tuple[float, float], ...]) -> Finding:
    """The finding about the steps of a fit."""
    signal, spectrum = answer.scale.signal, f.frame.spectrum
    unit, size = signal.sheet[0], [s for _, s in steps]
    time = spectrum.cut + np.array([t for t, _ in steps])
    span = spectrum.cut, spectrum.cut + spectrum.size / spectrum.rate
    each = [
        say("{size:+.3g} {unit} at {time:.4g} s", size=convert(s, signal.unit, unit), unit=unit, time=t)
        for t, s in zip(time, size, strict=True)
    ]
    apart = (span[1] - span[0]) / PLACES  # a low step is placed less well
    return Finding(
        "steps",
        say("the bias steps: {steps}", steps=join(", ", each)),
        say("the coefficients are those of the noise between the steps"),
        say("analyze the parts between the steps ({choice})",
            choice=longest_without(zip(time - apart, time + apart, strict=True), span)),
        (float(time[0]), float(time[0])),
    )  # fmt: skip


def vibration_finding(hidden: bool) -> Finding:
    """The finding that vibration leaves no frequency to the noise, or has as many as are looked for."""
    what = say("vibration at {count} or more frequencies, or one that changes its frequency", count=RESONANCES)
    if hidden:
        what = say("vibration has more power than the white noise of the sensor at all frequencies")
    harm = say("what it leaves of the noise cannot be checked")
    return Finding("vibration", what, harm, say("record at rest, on a quiet base"), fatal=True)


def exponent_finding(answer: Answer, f: Fitted) -> Finding:
    """The finding that the bias drift is not flicker."""
    part, scale = f.state.of("exponent")[0], answer.scale
    a = part.shape[0]
    low, high = profile_ends(f, part, 0, quantile(0.975) ** 2)
    harm, begins = say("B, K and Q are not meaningful as coefficients"), say("towards low frequencies")
    white = f.frame.white
    slow = float(f.theta[column_of_part(f.state, f.frame, part) or 0])
    if white is not None and f.theta[white] > 0 and slow > 0:
        law = answer.laws[white]
        unit = scale.signal.sheet[TERMS["N"].power]
        ends = [scale.coefficient("N", law.quantile(p)) for p in (0.16, 0.5, 0.84)] if law else [0.0] * 3
        value = ends[1] / coefficient_factor("N", unit, scale.signal)
        error = (ends[2] - ends[0]) / 2 / coefficient_factor("N", unit, scale.signal)
        harm = join("; ", (harm, f"N = {value:.4g} ± {error:.2g} {unit}"))
        corner = scale.rate * (slow / float(f.theta[white])) ** (1 / a)
        begins = say("below {frequency:.2g} Hz", frequency=min(corner, scale.rate / 2))
    return Finding(
        "flicker exponent",
        say("{where} the power spectral density falls as f^-{exponent:.2f} ({low:.2f} to {high:.2f}), not as f^-1",
            where=begins, exponent=a, low=low, high=high),
        harm,
        say("read the noise at the averaging times of interest off the Allan deviation"),
    )  # fmt: skip
