"""002: harmonic errors of the angle sensors of a gimbal."""

from tests.conformance.papers.rows import Row, arcsec

HOURS = "angle plan --latitude 60 --duration 3600 --q-law linear --start 0,3600,7200,10800,14400,18000 --csv -"
HALF = "angle plan --latitude 60 --duration 1800 --q-law linear --sway 1,60 --start 4500,8100,11700 --csv -"
ESTIMATE = "angle estimate hour.csv --difference difference --latitude 60 --rho rho --csv -"
SWAYING = HOURS.replace("--csv", "--sway 0.117,60 --interval 2 --csv")
SHORT = HOURS.replace("3600 ", "1800 ", 1)
CALIBRATE = "angle calibrate encoder.csv --measured measured --reference reference --csv -"

ROWS = (
    *(Row(f"Fig. 3: period under the sway solved from it, range {i + 1}", SWAYING,
          f"mean period 128 h [s] @ start [s]={3600 * i}", 360, 0.03) for i in range(6)),
    Row("under sway half the time is enough everywhere", HALF, "total @ start [s]=8100", 1.14, 0.05, 1.62, wrong=True),
    *(Row(f"eq. 5: {name}", ESTIMATE, f"value @ constant={name}", true, tolerance, read=arcsec)
      for name, true, tolerance in (("S128 h", 3, 0.1), ("C128 h", -1.5, 0.1), ("S256 h", 1, 0.15), ("C256 h", 2, 0.1),
                                    ("S128 q", -2, 0.15), ("C128 q", 1, 0.25), ("S256 q", 1.5, 0.2), ("C256 q", 1,
                                    0.25))),
    *(Row(f"half an hour is enough: sum of range {i + 1}", SHORT, f"total @ start [s]={3600 * i}", published, tolerance)
      for i, (published, tolerance) in enumerate(
          ((8.43, 0.1), (3.70, 0.25), (2.52, 0.1), (2.86, 0.1), (4.72, 0.2), (14.4, 0.25)))),
    *(Row(f"Fourier of computed minus measured angle: {name}", CALIBRATE, f"value @ constant={name}", true, 0.01,
          read=arcsec) for name, true in (("S128", 4.1253), ("C256", 2.0626))),
)  # fmt: skip
