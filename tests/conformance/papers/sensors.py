"""002: harmonic errors of the angle sensors of a gimbal."""

import math

from tests.conformance.papers.rows import Drawn, Row, Told, arcsec, minutes, ratio

HOURS = "angle plan --latitude 60 --duration 3600 --q-law linear --start 0,3600,7200,10800,14400,18000 --csv -"
HALF = "angle plan --latitude 60 --duration 1800 --q-law linear --sway 1,60 --start 4500,8100,11700 --csv -"
ESTIMATE = "angle estimate hour.csv --difference difference --latitude 60 --rho rho --csv -"
SWAYING = HOURS.replace("--csv", "--sway 0.117,60 --interval 2 --csv")
TURNED = "angle plan --latitude 60 --duration 1800 --ring-rate 2 --start 15300,18900 --csv -"
SHORT = HOURS.replace("3600 ", "1800 ", 1)
CALIBRATE = "angle calibrate encoder.csv --measured measured --reference reference --csv -"
SIX_HOURS = "--latitude 60 --duration 21600 --q-law linear --error h:128=1,0"
BEST = "total @ start [s]=7200"

ROWS = (
    *(Row(f"Table 1: sum of range {i + 1} over the best", HOURS, (f"total @ start [s]={3600 * i}", BEST),
          published, tolerance, ours, read=ratio)
      for i, (published, tolerance, ours) in enumerate(
          ((2.56, 0.85, 4.62), (1.59, 0.25, 1.25), (1.0, 0.0, 1.0), (1.15, 0.1, 1.24), (2.2, 0.2, 1.83), (8.2, 0.1,
          7.69)))),
    Row("optimum from, deg", HOURS, "h low [rad] @ start [s]=7200", 14, 0.05, read=math.degrees),
    Row("optimum to, deg", HOURS, "h high [rad] @ start [s]=7200", 20, 0.05, read=math.degrees),
    Row("Fig. 2: period of harmonic 128 at the start, min", HOURS, "period 128 h [s] @ start [s]=0", 12, 0.1, 22.44,
        wrong=True, read=minutes),
    Row("Fig. 2: period of harmonic 256 at the start, min", HOURS, "period 256 h [s] @ start [s]=0", 12, 0.1,
        read=minutes),
    Row("period of harmonic 128 of q, min", HOURS, "mean period 128 q [s] @ start [s]=0", 11, 0.03, read=minutes),
    *(Row(f"Fig. 3: period under sway, range {i + 1}, min", SWAYING, f"mean period 128 h [s] @ start [s]={3600 * i}", 6,
          0.03, read=minutes) for i in range(6)),
    Row("ref. 5: a turned ring, half an hour at the extreme", TURNED, "total @ start [s]=18900", 15.4, 0.05, 4.13,
        wrong=True),
    Row("under sway half the time is enough everywhere", HALF, "total @ start [s]=8100",
        1.14, 0.05, 1.62, wrong=True),
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

TOLD = (
    Told("eqs. 2, 3: the polar gyro", "angle estimate hour.csv --difference difference --latitude 60 --rho rho "
         "--angles h,q,h_polar", "its sensors can be estimated under sway only", 3),
)  # fmt: skip

DRAWN = (
    Drawn("Fig. 2", f"angle simulate still.csv {SIX_HOURS} --plot fig.svg"),
    Drawn("Fig. 3", f"angle simulate sway.csv {SIX_HOURS} --interval 2 --sway 0.117,60 --plot fig.svg"),
)
