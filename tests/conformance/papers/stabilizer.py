"""000, Gazaryan, Tairov, Ponomarev: errors of a gyro stabilizer."""

import math

import numpy as np
from tests.conformance.papers.direct import allan, hadamard, overlapping, values
from tests.conformance.papers.rows import Row, arcsec, ratio

COEFFICIENTS = "analyze run1.csv --coefficients -"
MEANING = "analyze run2.csv --device stabilizer"
TRUTH = (("N", 0.28458, 0.03), ("R", 0.49998, 0.01), ("GM", 1.2, 0.1))

ROWS = (
    Row("eq. 2", "deviation white.npz --statistic adev --m 1,10,100 --no-intervals --csv -",
        "deviation @ m=10", lambda: allan("white.npz", 10), 1e-9),
    Row("eq. 8", "deviation white.npz --statistic oadev --m 1,10,100 --no-intervals --csv -",
        "deviation @ m=100", lambda: overlapping("white.npz", 100), 1e-9),
    Row("eq. 12", "deviation white.npz --statistic ohdev --m 1,10,100 --no-intervals --csv -",
        "deviation @ m=10", lambda: hadamard("white.npz", 10), 1e-9),
    Row("at M = 1 the Allan variance of any noise is the variance",
        "deviation walk.npz --m 1 --no-intervals --csv -", "deviation @ m=1",
        lambda: np.std(values("walk.npz")), 0.1, 0.0095324, wrong=True),
    Row("a constant does not matter", "deviation biased.npz --m 10 --no-intervals --csv -",
        "deviation @ m=10", lambda: overlapping("white.npz", 10), 1e-9),
    Row("eq. 9: from a measured spectrum", "spectrum white.npz --deviation oadev --csv -",
        "deviation @ m=16", lambda: overlapping("white.npz", 16), 0.03),
    *(Row(f"eq. 10, {run} run: {symbol}", command, f"value @ term={symbol}", value, tolerance)
      for run, command in (("first", COEFFICIENTS), ("second", f"{MEANING} --coefficients -"))
      for symbol, value, tolerance in TRUTH),
    Row("Fig. 2: top of a sinusoid, at 0.371 of the period",
        "deviation --model 'Sine 1 deg/h 3 Hz' --rate 1000 --duration 100 --taus 0.124 --csv -",
        "deviation", 0.725, 0.002, read=arcsec),
    Row("Fig. 2: top of correlated noise, at 1.89 time constants",
        "deviation --model 'GM 1 deg/h 1 s' --rate 100 --duration 100 --taus 1.89 --csv -",
        "deviation", 0.617, 0.002, read=arcsec),
    Row("conclusion 4: time constant of the loop", COEFFICIENTS, "value @ term=GM.time_constant", 2.0, 0.2),
    *(Row(f"oscillation of a loop: {term}", "analyze loop.npz --terms N,GM2 --coefficients -", f"value @ term={term}",
          value, tolerance) for term, value, tolerance in (
          ("GM2", 1.0, 0.1), ("GM2.frequency", 0.3, 0.1), ("GM2.damping", 0.15, 0.3))),
    Row("limits of the modified deviation are numbers", "deviation run1.csv --statistic mdev --taus log --csv -",
        "rms high", 1.0, 0.0, read=lambda high: float(math.isfinite(high))),
    Row("Hadamard: blind to a ramp",
        "deviation --model 'N 1 deg/sqrt(h), R 5 deg/h^2' --rate 1 --duration 2h --statistic ohdev --taus 100 --csv -",
        ("R", "deviation"), 0.0, 1e-9, read=ratio),
    Row("second run: change of N, %", "compare run1.csv run2.csv --csv -",
        "change_percent @ quantity=N", 0.0, 3.0),
    Row("two runs in one table", "analyze run1.csv run2.csv --coefficients -",
        "value @ file=run2.csv & term=N", 0.28458, 0.05),
    Row("conclusion 5: K from the Hadamard deviation",
        "deviation drift.npz --statistic ohdev --taus 100 --no-intervals --csv -",
        ("deviation", "tau_s"), 0.3, 0.3, read=lambda hadamard, tau: hadamard * math.sqrt(6 / tau)),
    Row("conclusion 5: K by the likelihood", "analyze drift.npz --coefficients -", "value @ term=K", 0.3, 0.3),
    Row("p. 149: the sign of the drift", "analyze drift.npz --coefficients -", "value @ term=R", -0.5, 0.1),
    Row("conclusion 5: R has a sign", COEFFICIENTS, "low @ term=R", 0.49998, 0.01),
    *(Row(f"sine and cosine of a resolver: {symbol}", "analyze resolver.csv --sincos az_sin,az_cos --coefficients -",
          f"value @ term={symbol}", value, tolerance) for symbol, value, tolerance in TRUTH),
    Row("the angle taken for increments, which gives wrong numbers that look right: N",
        "analyze run1.csv --kind increment --coefficients -", "si_value @ term=N", 0.28458, 0.03, 2.830, wrong=True,
        read=arcsec),
)  # fmt: skip
