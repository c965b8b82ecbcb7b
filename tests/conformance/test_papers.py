"""What five papers say, by commands as anybody can type them: the number of the paper, and ours.

The papers publish no records, so that simulated ones stand in. Where a paper is wrong, the row holds the number that
replaces its own. A cell is a column of the CSV output and the row it is read in, ``value @ term=N``, the last row,
``tau_s @ last``, or, from ``/``, a path into the JSON output.
"""

import csv
import io
import json
import math
import shlex
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from click.testing import CliRunner

import allanite as al
from allanite.cli import main

ANGLE = "N 0.004743 arcmin*sqrt(s), R 0.008333 arcmin/s, GM 0.02 arcmin 2 s"
FOG = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h), R 5 deg/h^2"
BEFORE = "Q 0.963036 arcsec, N 2.525648 deg/sqrt(h), B 12.023988 deg/h, K 32.72457 deg/h/sqrt(h), R 38.789995 deg/h^2"
AFTER = "Q 0.916159 arcsec, N 2.365199 deg/sqrt(h), B 3.235266 deg/h, K 10.682979 deg/h/sqrt(h), R 23.970946 deg/h^2"
FIVE = "Q 1 arcsec, N 1 deg/sqrt(h), B 1 deg/h, K 1 deg/h/sqrt(h), R 1 deg/h^2"
ERRORS = "--error h:128=3,-1.5 --error h:256=1,2 --error q:128=-2,1 --error q:256=1.5,1"

INPUTS = (
    f"simulate short.csv --model '{ANGLE}' --unit arcmin --rate 40 --duration '10 min'",
    f"simulate run1.csv --model '{ANGLE}' --unit arcmin --rate 10 --duration '60 min'",
    f"simulate run2.csv --model '{ANGLE}' --unit arcmin --rate 10 --duration '30 min' --seed 3",
    "simulate white.npz --model 'N 1 deg/sqrt(h)' --rate 1 --samples 7200",
    "simulate biased.npz --model 'N 1 deg/sqrt(h)' --rate 1 --samples 7200 --constant '1000 deg/h'",
    "simulate walk.npz --model 'K 1 deg/h/sqrt(h)' --rate 1 --samples 7200",
    "simulate loop.npz --model 'N 0.01 deg/sqrt(h), GM2 1 deg/h 0.3 Hz 0.15' --rate 10 --duration '20 min'",
    f"simulate fog.npz --model '{FOG}' --rate 1 --duration '2 h'",
    "simulate step.npz --model 'N 1 deg/sqrt(h)' --rate 1 --duration '2 h' --noise-profile '0:1, 3599:1, 3600:3'",
    f"angle simulate hour.csv --latitude 60 --duration 3600 --q-law linear --start 7200 {ERRORS}",
    "simulate gl1.npz --sensor gl1 --constant '12.4392 deg/h' --rate 400 --duration '40 min'",
    "simulate smooth.npz --sensor gl1-smooth --constant '12.4392 deg/h' --rate 400 --duration '40 min'",
    "simulate turned1.npz --sensor gl1 --constant '2.8921 deg/h' --rate 400 --duration '10 min'",
    "simulate turned2.npz --sensor gl1 --constant '-2.8921 deg/h' --rate 400 --duration '10 min' --seed 2",
    f"simulate before.npz --model '{BEFORE}' --rate 1000 --duration 60",
    f"simulate after.npz --model '{AFTER}' --rate 1000 --duration 60 --seed 2",
    "simulate line.npz --model 'N 0.1 deg/sqrt(h), Sine 5 deg/h 0.02 Hz' --rate 10 --duration '20 min'",
    "simulate clean.npz --model 'N 0.1 deg/sqrt(h)' --rate 10 --duration '20 min' --seed 2",
    "simulate volts.npz --model 'N 1e-3 V*sqrt(s)' --unit V --rate 100 --duration 60",
)


@dataclass(frozen=True)
class Row:
    """A claim, the command and its cells, the number that is printed, its relative tolerance, and ours."""

    paper: str
    item: str
    command: str
    cells: str | tuple[str, ...]
    published: float | Callable[[], float]
    tolerance: float
    ours: float | None = None
    wrong: bool = False
    read: Callable[..., float] = float

    def __str__(self):
        return f"{self.paper} {self.item}"


def ratio(one, other):
    return one / other


def slope(first, second):
    """Over two decades."""
    return math.log10(second / first) / 2


def percent(edf):
    """Relative standard error of a deviation."""
    return 100 / math.sqrt(2 * edf)


def arcsec(rad):
    return math.degrees(rad) * 3600


def of_degree_per_hour(rad_per_s):
    return arcsec(rad_per_s)


def minutes_of_a_period(low, high):
    """Mean period of harmonic 128 of an angle that goes from `low` to `high` in an hour."""
    return 60 * (2 * math.pi / 128) / (high - low)


def values(name):
    return al.read(name).records[0].values


def averages(x, m):
    return np.convolve(x, np.full(m, 1 / m), "valid")


def allan(name, m):
    """Eq. 2 of 000 and eq. 3 of 001."""
    x = values(name)
    return math.sqrt(0.5 * np.mean(np.diff(x[: x.size // m * m].reshape(-1, m).mean(axis=1)) ** 2))


def overlapping(name, m):
    """Eq. 8 of 000, with the sequence that starts at zero."""
    y = np.concatenate(([0.0], np.cumsum(values(name))))
    return math.sqrt(np.mean((y[2 * m :] - 2 * y[m:-m] + y[: -2 * m]) ** 2) / (2 * m * m))


def hadamard(name, m):
    """Eq. 12 of 000, with the averages that it means."""
    y = averages(values(name), m)
    return math.sqrt(np.mean((y[2 * m :] - 2 * y[m:-m] + y[: -2 * m]) ** 2) / 6)


def theo1(name, m):
    """Eq. 6 of 001 as the double sum that it is."""
    x = np.concatenate(([0.0], np.cumsum(values(name))))
    i = np.arange(x.size - m)
    total = np.zeros(i.size)
    for d in range(m // 2):
        ahead = x[i] - x[i - d + m // 2] + x[i + m] - x[i + d + m // 2]
        total += ahead**2 / (m // 2 - d)
    return math.sqrt(total.sum() / (0.75 * (x.size - m) * m**2))


def stability(name, m):
    return np.std(values(name).reshape(-1, m).mean(axis=1), ddof=1)


COEFFICIENTS = "analyze run1.csv --terms N,R,GM --coefficients -"
AUTOMATIC = "analyze short.csv --coefficients -"
VERTICAL = "vertical --gyro 'N 0.3 deg/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz)'"
COLOURED = (
    "vertical --gyro 'N 0.3 deg/sqrt(h), B 10 deg/h, K 20 deg/h/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz), B 50 ug'"
)

STABILIZER = (
    Row("000", "eq. 2", "deviation white.npz --statistic adev --m 1,10,100 --no-intervals --csv -",
        "deviation @ m=10", lambda: allan("white.npz", 10), 1e-9),
    Row("000", "eq. 8", "deviation white.npz --statistic oadev --m 1,10,100 --no-intervals --csv -",
        "deviation @ m=100", lambda: overlapping("white.npz", 100), 1e-9),
    Row("000", "eq. 12", "deviation white.npz --statistic ohdev --m 1,10,100 --no-intervals --csv -",
        "deviation @ m=10", lambda: hadamard("white.npz", 10), 1e-9),
    Row("000", "at M = 1 the Allan variance of any noise is the variance",
        "deviation walk.npz --m 1 --no-intervals --csv -", "deviation @ m=1",
        lambda: np.std(values("walk.npz")), 0.1, 0.0095324, wrong=True),
    Row("000", "a constant does not matter", "deviation biased.npz --m 10 --no-intervals --csv -",
        "deviation @ m=10", lambda: overlapping("white.npz", 10), 1e-9),
    Row("000", "eq. 9: from a measured spectrum", "spectrum white.npz --deviation oadev --csv -",
        "deviation @ m=16", lambda: overlapping("white.npz", 16), 0.03),
    Row("000", "eq. 10: N", COEFFICIENTS, "value @ term=N", 0.28458, 0.03),
    Row("000", "eq. 10: R", COEFFICIENTS, "value @ term=R", 0.49998, 0.01),
    Row("000", "eq. 10: GM", COEFFICIENTS, "value @ term=GM", 1.2, 0.1),
    *(Row("000", f"eq. 10, terms not named: {symbol}", AUTOMATIC, f"value @ term={symbol}", value, tolerance)
      for symbol, value, tolerance in (("N", 0.28458, 0.03), ("R", 0.49998, 0.01), ("GM", 1.2, 0.1))),
    Row("000", "slopes: N", "analyze run1.csv --method piecewise --ranges N=0.1:0.2,R=20:120 --coefficients -",
        "value @ term=N", 0.28458, 0.1),
    Row("000", "slopes: R", "analyze run1.csv --method piecewise --ranges N=0.1:0.2,R=20:120 --coefficients -",
        "value @ term=R", 0.49998, 0.01),
    *(Row("000", f"Fig. 1: slope of {symbol}",
          f"deviation --model '{FIVE}' --rate 1 --duration '10 h' --taus 10,1000 --csv -",
          (f"{symbol} @ tau_s=10", f"{symbol} @ tau_s=1000"), expected, 0.01, read=slope)
      for symbol, expected in (("Q", -1.0), ("N", -0.5), ("B", 0.0), ("K", 0.5), ("R", 1.0))),
    Row("000", "Fig. 2: top of a sinusoid, at 0.371 of the period",
        "deviation --model 'Sine 1 deg/h 3 Hz' --rate 1000 --duration 100 --taus 0.124 --csv -",
        "deviation", 0.725, 0.002, read=of_degree_per_hour),
    Row("000", "Fig. 2: top of correlated noise, at 1.89 time constants",
        "deviation --model 'GM 1 deg/h 1 s' --rate 100 --duration 100 --taus 1.89 --csv -",
        "deviation", 0.617, 0.002, read=of_degree_per_hour),
    Row("000", "oscillation of a loop", "analyze loop.npz --terms N,GM2 --coefficients -", "value @ term=GM2", 1.0,
        0.1),
    Row("000", "limits of the modified deviation that are no numbers",
        "deviation run1.csv --statistic mdev --taus log --csv -", "blank high", 0.0, 0.0),
    Row("000", "Hadamard: blind to a ramp",
        "deviation --model 'N 1 deg/sqrt(h), R 5 deg/h^2' --rate 1 --duration 2h --statistic ohdev --taus 100 --csv -",
        ("R", "deviation"), 0.0, 1e-9, read=ratio),
    Row("000", "truncated run: change of R, %", "compare run1.csv --part 1800 --terms N,R,GM --csv -",
        "change_percent @ quantity=R", 0.0, 1.0),
    Row("000", "second run: change of N, %", "compare run1.csv run2.csv --terms N,R,GM --csv -",
        "change_percent @ quantity=N", 0.0, 3.0),
    Row("000", "two runs in one table", "analyze run1.csv run2.csv --terms N,R,GM --coefficients -",
        "value @ file=run2.csv, term=N", 0.28458, 0.05),
    Row("000", "conclusion 3: the minimum", COEFFICIENTS, "value @ term=minimum", 0.618, 0.05),
    Row("000", "conclusion 5: R has a sign", COEFFICIENTS, "low @ term=R", 0.49998, 0.01),
    Row("vertical", "best time constant, s", f"{VERTICAL} --json -", "/optimum/time_constant", 1.1459, 0.002),
    Row("vertical", "its error", f"{VERTICAL} --json -", "/optimum/first/rms", 19.27, 0.002, read=arcsec),
    *(Row("vertical", f"detuned {factor} times", f"{VERTICAL} --json -", f"/optimum/detuning/{i}/1", error, 0.005,
          read=arcsec)
      for i, factor, error in ((0, 0.25, 28.1), (1, 0.5, 21.5), (3, 2, 21.5), (4, 4, 28.1))),
    Row("vertical", "bias: time constant, s", f"{VERTICAL} --gyro-bias '10 deg/h' --json -", "/optimum/time_constant",
        0.810, 0.002),
    Row("vertical", "bias: error", f"{VERTICAL} --gyro-bias '10 deg/h' --json -", "/optimum/first/rms", 21.43, 0.002,
        read=arcsec),
    *(Row("vertical", f"Kalman: {gain}", VERTICAL.replace("0.3 deg/sqrt(h)",
          "0.3 deg/sqrt(h), K 20 deg/h/sqrt(h)") + " --json -",
          f"/optimum/second/loop/{gain}", value, 0.04) for gain, value in (("k1", 0.89099), ("k2", 0.016160))),
    Row("vertical", "flicker, 10 min: time constant, s", f"{COLOURED} --duration '10 min' --json -",
        "/optimum/time_constant", 0.762, 0.02),
    Row("vertical", "flicker, 10 min: error", f"{COLOURED} --duration '10 min' --json -", "/optimum/first/rms", 26.3,
        0.01, read=arcsec),
    Row("vertical", "flicker, 1 h: time constant, s", f"{COLOURED} --duration '1 h' --json -",
        "/optimum/time_constant", 0.691, 0.03),
    Row("vertical", "flicker, 1 h: error", f"{COLOURED} --duration '1 h' --json -", "/optimum/first/rms", 28.3, 0.01,
        read=arcsec),
)  # fmt: skip

EXPLAIN = "explain theo1 --samples 7200 --taus 9,75,540,750,1080,2700,4050,5400 --csv -"
BIAS = {"B": (1.685, 1.835, 1.864), "K": (2.464, 2.661, 2.694), "Q": (0.397, 0.222, 0.142)}
EDF = {100: 387, 720: 51.6, 1440: 24.2, 3600: 7.8, 5400: 4.2, 7200: 2.4}

THEOH = (
    Row("001", "means of 10 s", "analyze white.npz --terms N --coefficients -", "value @ name=10 s stability",
        lambda: stability("white.npz", 10), 1e-6),
    Row("001", "eq. 3", "deviation white.npz --statistic adev --m 100 --no-intervals --csv -", "deviation",
        lambda: allan("white.npz", 100), 1e-9),
    Row("001", "eq. 5: error of 72 groups, %", "explain adev --samples 7200 --taus 100 --csv -", "edf N",
        8.40, 0.05, 10.25, wrong=True, read=percent),
    Row("001", "the same, overlapping, %", "explain oadev --samples 7200 --taus 100 --csv -", "edf N", 6.9, 0.01,
        read=percent),
    *(Row("001", f"eq. 6, m = {m}", f"deviation white.npz --statistic theo1 --m {m} --no-intervals --csv -",
          "deviation",
          lambda m=m: theo1("white.npz", m), 1e-9) for m in (10, 1000, 7200)),
    Row("001", "longest averaging time, s", "deviation fog.npz --statistic theo1 --taus all --no-intervals --csv -",
        "tau_s @ last", 5400, 0.0),
    Row("001", "that of Allan, s", "deviation fog.npz --statistic adev --taus all --no-intervals --csv -",
        "tau_s @ last", 3600, 0.0),
    *(Row("001", f"Table 1: {symbol}, m = {m}", EXPLAIN, f"ratio {symbol} @ m={m}", published, 0.04)
      for symbol, row in BIAS.items() for m, published in zip((12, 100, 1000), row, strict=True)),
    *(Row("001", f"Table 2: N, m = {m}", EXPLAIN, f"edf N @ m={m}", published, 0.17 if m == 7200 else 0.1)
      for m, published in EDF.items()),
    Row("001", "Table 2: N, m = 10", "deviation white.npz --terms N --statistic theo1 --m 10 --csv -", "edf", 3139,
        0.1),
    Row("001", "Table 2: K, m = 7200", EXPLAIN, "edf K @ m=7200", -0.27, 0.1, 1.05, wrong=True),
    Row("001", "TheoH has no bias",
        f"deviation --model '{FOG}' --rate 1 --duration '2 h' --statistic theoh,oadev --taus 1500 --csv -",
        ("deviation @ statistic=theoh", "deviation @ statistic=oadev"), 1.0, 0.05, 0.859, wrong=True, read=ratio),
    Row("001", "the same, with the bias of the model",
        "deviation fog.npz --statistic theoh,oadev --taus 1440,1500 --bias model --csv -",
        ("deviation @ statistic=theoh, tau_s=1500", "deviation @ statistic=oadev, tau_s=1500"), 1.0, 0.03, read=ratio),
    Row("001", "joint at 10 % of the record",
        "deviation fog.npz --statistic theoh,theobr --join 0.1 --no-intervals --taus 1080 --csv -",
        ("deviation @ statistic=theoh", "deviation @ statistic=theobr"), 1.0, 1e-9, read=ratio),
    Row("001", "eq. 13: lower 90 % limit, %",
        "deviation white.npz --terms N --statistic theo1 --m 720 --level 0.9 --csv -",
        ("low", "deviation"), -13.5, 0.05, read=lambda low, middle: 100 * (low / middle - 1)),
    Row("001", "eq. 13: upper 90 % limit, %",
        "deviation white.npz --terms N --statistic theo1 --m 720 --level 0.9 --csv -",
        ("high", "deviation"), 19, 0.05, read=lambda high, middle: 100 * (high / middle - 1)),
    Row("001", "eq. 12", "deviation white.npz --terms N --statistic theo1 --m 720 --edf published --power-law --csv -",
        "edf", 51.6, 0.01),
    Row("001", "Fig. 3: the noise at each time",
        "deviation white.npz --terms N --statistic theo1 --m 720 --edf published --power-law --csv -",
        "alpha", 0.0, 0.0),
    *(Row("001", f"five terms of TheoH: {symbol}",
          "analyze fog.npz --method nnls --statistic theoh --taus octave --coefficients -",
          f"value @ term={symbol}", true, tolerance)
      for symbol, true, tolerance in (("N", 0.02, 0.2), ("B", 0.3, 0.4), ("R", 5.0, 0.2))),
    *(Row("001", f"the same by gls: {symbol}",
          "analyze fog.npz --method gls --statistic theoh --taus octave --coefficients -",
          f"value @ term={symbol}", true, tolerance)
      for symbol, true, tolerance in (("N", 0.02, 0.1), ("B", 0.3, 0.2), ("R", 5.0, 0.2))),
    Row("001", "means first: N", "analyze fog.npz --average 10 --coefficients -", "value @ term=N", 0.02, 0.2),
)  # fmt: skip

HOURS = "angle plan --latitude 60 --duration 3600 --q-law linear --start 0,3600,7200,10800,14400,18000 --csv -"
HALF = "angle plan --latitude 60 --duration 1800 --q-law linear --sway 1,60 --start 4500,8100,11700 --csv -"
ESTIMATE = "angle estimate hour.csv --difference difference --latitude 60 --rho rho --csv -"
BEST = "total @ start [s]=7200"

SENSORS = (
    *(Row("002", f"Table 1: sum of range {i + 1} over the best", HOURS, (f"total @ start [s]={3600 * i}", BEST),
          published, tolerance, ours, read=ratio)
      for i, (published, tolerance, ours) in enumerate(
          ((2.56, 0.85, 4.62), (1.59, 0.25, 1.25), (1.0, 0.0, 1.0), (1.15, 0.1, 1.24), (2.2, 0.2, 1.83), (8.2, 0.1,
          7.69)))),
    Row("002", "optimum from, deg", HOURS, "h low [rad] @ start [s]=7200", 14, 0.05, read=math.degrees),
    Row("002", "optimum to, deg", HOURS, "h high [rad] @ start [s]=7200", 20, 0.05, read=math.degrees),
    Row("002", "period of harmonic 128 at the start, min", HOURS, ("h low [rad] @ start [s]=0",
        "h high [rad] @ start [s]=0"),
        12, 0.1, 22.6, wrong=True, read=minutes_of_a_period),
    Row("002", "under sway half the time is enough everywhere", HALF, "total @ start [s]=8100",
        1.14, 0.05, 1.62, wrong=True),
    *(Row("002", f"eq. 5: {name}", ESTIMATE, f"value @ constant={name}", true, tolerance, read=arcsec)
      for name, true, tolerance in (("S128 h", 3, 0.1), ("C128 h", -1.5, 0.1), ("S256 h", 1, 0.15), ("C256 h", 2, 0.1),
                                    ("S128 q", -2, 0.15), ("C128 q", 1, 0.25), ("S256 q", 1.5, 0.2), ("C256 q", 1,
                                    0.25))),
)  # fmt: skip

GL1 = "--latitude 55.7936 --noise 'N 0.000291797 deg/sqrt(h), Q 0.254442 arcsec' --no-times"
RATE = f"rate gl1.npz --bias -0.0948 {GL1} --csv -"
TIMES = "rate smooth.npz --methods mean --durations 1,5,10,30 --noise 'Q 0.02367 arcsec, GMA 0.29 arcsec 15 s' --csv -"

LASER = (
    *(Row("003", f"Table 3: {method}", RATE, f"std @ method={method}", published, tolerance)
      for method, published, tolerance in (("mean", 0.0034, 0.25), ("hamming", 0.0022, 0.35), ("conditional", 0.0018,
      0.35),
                                           ("staircase", 0.0013, 0.45))),
    Row("003", "mean over staircase", RATE, ("std @ method=mean", "std @ method=staircase"), 2.6, 0.35, read=ratio),
    *(Row("003", f"Table 1: {seconds} s", TIMES, f"predicted @ duration_s={seconds}", published, tolerance)
      for seconds, published, tolerance in ((1, 0.108, 0.03), (5, 0.0435, 0.03), (10, 0.028, 0.04), (30, 0.0159, 0.25),
                                            (120, 0.0034, 0.05))),
    *(Row("003", f"Table 1, measured: {seconds} s", TIMES, f"std @ duration_s={seconds}", published, tolerance)
      for seconds, published, tolerance in ((1, 0.108, 0.15), (5, 0.0435, 0.2), (10, 0.028, 0.3))),
    Row("003", "mean of all, deg/h", TIMES, "rate @ duration_s=120", 12.335042, 0.001),
    Row("003", "two positions: heading, deg",
        f"rate turned1.npz --second turned2.npz --horizontal --near 60 --methods optimal {GL1} --json -",
        "/channels/0/north/heading", 70, 0.001),
    Row("003", "LN-90A, 4 min: mean", f"rate gl1.npz --bias -0.0948 --interval 240 --methods mean {GL1} --csv -",
        "std @ method=mean", 0.0022, 0.35),
)  # fmt: skip

TABLE2 = "analyze before.npz --coefficients -"
COMPARED = "compare before.npz after.npz --csv -"
ADC = "budget volts.npz --sense 5 --scale-factor 0.2 --stage 'ADC 12 5V' --stage 'ADC 8 5V' --csv -"

TORQUE = (
    Row("004", "Table 2: Q", TABLE2, "value @ term=Q", 0.963036, 0.1),
    Row("004", "Table 2: N", TABLE2, "value @ term=N", 2.525648, 0.03),
    Row("004", "Table 3: change of Q, %", COMPARED, ("after @ quantity=Q", "before @ quantity=Q"),
        0.916159 / 0.963036, 0.1, read=ratio),
    Row("004", "Table 3: change of N, %", COMPARED, "change_percent @ quantity=N", -6.35, 0.3),
    Row("004", "8 bits, V", ADC, "step @ bits=8", 0.03906, 1e-3),
    Row("004", "12 bits, V", ADC, "step @ bits=12", 0.002441, 1e-3),
    Row("004", "a gain of 10 before it", ADC.replace("12 5V", "12 5V gain=10"), "step @ bits=12", 0.0002441, 1e-3),
    Row("004", "a line that has gone: deviation at 25.6 s", "compare line.npz clean.npz --csv -",
        ("after @ quantity=oadev, tau_s=25.6", "before @ quantity=oadev, tau_s=25.6"), 0.15, 0.15, read=lambda after,
        before: (after / before) ** 2),
)  # fmt: skip

SLOPES = "analyze run1.csv --terms N,R,GM --device stabilizer"
TOLD = (
    ("000", "table of slopes", SLOPES, "random component of the angular stabilization error"),
    ("000", "conclusions 1, 2: white noise", SLOPES, "White noise (white noise of the angle) dominates up to 0.4"),
    ("000", "conclusions 1, 2: drift", SLOPES, "Drift (ramp) dominates from 1.9"),
    ("000", "conclusion 4", SLOPES, "A Gauss-Markov process with a time constant of 2.0"),
    ("000", "conclusion 5", SLOPES, "The drift is systematic"),
    ("000", "truncated run", "compare run1.csv --part 1800 --terms N,R,GM", "no change of the noise is detected"),
    ("000", "second run", "compare run1.csv run2.csv --terms N,R,GM", "no change of the noise is detected"),
    ("001", "the jump of TheoH", "deviation fog.npz --statistic theoh --taus octave --bias plain", "theoh jumps there"),
    ("001", "Fig. 6", "analyze step.npz", "the noise level changes by a factor of 3"),
    ("003", "where averaging is right", "rate walk.npz --noise 'K 1 deg/h/sqrt(h)' --no-times --methods mean",
     "under this model the rate is measured without error"),
    ("004", "the least squares of the paper", "analyze before.npz --method ls",
     "a negative K^2, which has no physical meaning"),
    ("004", "3.1 sources", "analyze before.npz --device mscsg",
     "the analogue-to-digital converter of the coil current"),
    ("004", "3.2 remedies", "analyze before.npz --device mscsg", "a controller that suppresses vibration"),
    ("004", "how long for B, K and R", "compare before.npz after.npz",
     "not resolvable in these records, but in longer ones: B (at"),
    ("004", "a line that has gone", "compare line.npz clean.npz", "Sine at 0.02005 Hz -100 %"),
)  # fmt: skip

DRAWN = (
    ("000", "Fig. 1", f"deviation --model '{FIVE}' --rate 1 --duration '10 h' --plot fig.svg"),
    ("000", "Fig. 3", "deviation run2.csv --statistic adev,oadev,mdev,ohdev --taus log --no-intervals --plot fig.svg"),
    ("001", "Fig. 9", "deviation fog.npz --statistic adev,theo1,theobr,theoh --taus log --no-intervals --plot fig.svg"),
    ("002", "Fig. 2", "angle estimate hour.csv --difference difference --latitude 60 --rho rho --plot fig.svg"),
    ("002", "Fig. 3", f"angle simulate sway.csv --latitude 60 --duration 3600 --sway 1,60 {ERRORS} --plot fig.svg"),
    ("003", "Figs. 3, 4, 5", f"rate turned1.npz --bias -0.0948 {GL1} --closeup fig.svg"),
    ("003", "Fig. 10", f"rate turned1.npz --bias -0.0948 {GL1} --plot fig.svg"),
    ("003", "Table 2", f"rate turned1.npz --bias -0.0948 {GL1} --readings fig.svg"),
    ("004", "Fig. 6", "compare before.npz after.npz --plot fig.svg"),
)  # fmt: skip

ROWS = (*STABILIZER, *THEOH, *SENSORS, *LASER, *TORQUE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("papers")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(where)
        for command in INPUTS:
            run(f"{command}{'' if command.startswith('angle') else ' --quiet'}")
        yield where


def run(command):
    done = CliRunner().invoke(main, shlex.split(command))
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture(scope="module")
def typed(folder):
    """The standard output of a command; the same command runs once."""
    found = {}
    return lambda command: found[command] if command in found else found.setdefault(command, run(command))


def number(text, cell):
    if cell.startswith("/"):
        found = json.loads(text)
        for key in cell[1:].split("/"):
            found = found[int(key) if isinstance(found, list) else key]
        return found
    rows = list(csv.DictReader(io.StringIO(text)))
    if cell.startswith("blank "):
        return sum(not math.isfinite(float(row[cell[6:]] or "nan")) for row in rows)
    column, _, where = cell.partition(" @ ")
    if where == "last":
        return float(rows[-1][column])
    wanted = dict(pair.split("=") for pair in where.split(", ")) if where else {}
    return float(next(row for row in rows if all(alike(row[key], value) for key, value in wanted.items()))[column])


def alike(shown, wanted):
    try:
        return math.isclose(float(shown), float(wanted), rel_tol=1e-9)
    except ValueError:
        return shown == wanted


@pytest.mark.parametrize("row", ROWS, ids=str)
def test_the_number_is_that_of_the_paper_or_the_one_that_replaces_it(typed, row):
    text = typed(row.command)
    cells = (row.cells,) if isinstance(row.cells, str) else row.cells
    found = row.read(*(number(text, cell) for cell in cells))
    published = row.published() if callable(row.published) else row.published
    near = pytest.approx(published, rel=row.tolerance, abs=row.tolerance if published == 0 else None)
    assert (found == near) is not row.wrong
    if row.ours is not None:
        assert found == pytest.approx(row.ours, rel=0.01)


@pytest.mark.parametrize(("paper", "item", "command", "words"), TOLD, ids=lambda cell: cell[:40])
def test_the_sentence_of_the_paper_is_said(typed, paper, item, command, words):
    assert words in " ".join(typed(command).split())


@pytest.mark.parametrize(("paper", "item", "command"), DRAWN, ids=lambda cell: cell[:20])
def test_the_figure_or_table_is_written(folder, paper, item, command):
    run(f"{command.replace('fig.svg', f'{paper}.svg')} --force{'' if 'simulate' in command else ' --quiet'}")
    assert (folder / f"{paper}.svg").stat().st_size > (200 if item.startswith("Table") else 10_000)
