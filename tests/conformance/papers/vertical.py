"""000, its end: Matveev's gyro-vertical, of which the abstract survives."""

from tests.conformance.papers.rows import Row, arcsec, ratio

VERTICAL = "vertical --gyro 'N 0.3 deg/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz)'"
COLOURED = (
    "vertical --gyro 'N 0.3 deg/sqrt(h), B 10 deg/h, K 20 deg/h/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz), B 50 ug'"
)
HOUR = f"{COLOURED} --duration '1 h'"
SCENARIOS = f"{VERTICAL} --scenarios --rate 50 --csv -"

ROWS = (
    *(Row(f"detuned {factor} times", f"{VERTICAL} --json -", f"/optimum/detuning/{i}/1", error, 0.005, read=arcsec)
      for i, factor, error in ((0, 0.25, 28.1), (1, 0.5, 21.5), (3, 2, 21.5), (4, 4, 28.1))),
    Row("bias: error", f"{VERTICAL} --gyro-bias '10 deg/h' --json -", "/optimum/first/rms", 21.43, 0.002, read=arcsec),
    Row("flicker, 10 min: time constant, s", f"{COLOURED} --duration '10 min' --json -",
        "/optimum/time_constant", 0.762, 0.02),
    Row("flicker, 1 h: time constant, s", f"{HOUR} --json -", "/optimum/time_constant", 0.691, 0.03),
    Row("flicker, 1 h: error", f"{HOUR} --json -", "/optimum/first/rms", 28.3, 0.01, read=arcsec),
    *(Row(f"scenario {scenario}, {name}: error, deg", SCENARIOS, f"{scenario} rms @ filter={name}", error, 0.06)
      for name, scenario, error in (
          ("accelerometer", "acceleration", 2.378), ("first order, 1 s", "acceleration", 2.286),
          ("first order, 10 s", "acceleration", 1.465), ("madgwick, beta 0.033", "acceleration", 2.300),
          ("madgwick, beta 0.001", "acceleration", 0.555), ("mahony, 50 s", "acceleration", 0.467),
          ("first order, 1 s", "oscillation", 0.507), ("accelerometer", "oscillation", 0.838),
          ("madgwick, beta 0.033", "oscillation", 0.838))),
    Row("scenario acceleration: what a gate on the norm gains", SCENARIOS,
        ("acceleration rms @ filter=100 s, norm gate 0.02 g", "acceleration rms @ filter=first order, 100 s"), 1.0, 0.0,
        read=ratio),
    Row("no filter is better than the bound", f"{VERTICAL} --json -", ("/optimum/bound", "/optimum/first/rms"), 1.0,
        0.001, read=ratio),
)  # fmt: skip
