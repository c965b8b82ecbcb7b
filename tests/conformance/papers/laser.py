"""003, Enin, Saneev: the rate of a laser gyro in minutes."""

from tests.conformance.papers.rows import Drawn, Row, Told, arcsec, ratio

GL1 = "--latitude 55.7936 --noise 'N 0.000291797 deg/sqrt(h), Q 0.254442 arcsec' --no-times"
RATE = f"rate gl1.npz --bias -0.0948 {GL1} --csv -"
TIMES = "rate smooth.npz --methods mean --durations 1,5,10,30 --noise 'Q 0.02367 arcsec, GMA 0.29 arcsec 15 s' --csv -"
TURNED = f"rate turned1.npz --second turned2.npz --horizontal --near 60 --methods optimal {GL1} --json -"
READINGS = f"rate gl1.npz --bias -0.0948 --methods optimal {GL1} --readings -"

ROWS = (
    *(Row(f"Table 3: {method}", RATE, f"std @ method={method}", published, tolerance)
      for method, published, tolerance in (("mean", 0.0034, 0.25), ("hamming", 0.0022, 0.35), ("conditional", 0.0018,
      0.35),
                                           ("staircase", 0.0013, 0.45))),
    Row("mean over staircase", RATE, ("std @ method=mean", "std @ method=staircase"), 2.6, 0.35, read=ratio),
    *(Row(f"Table 1: {seconds} s", TIMES, f"predicted @ duration_s={seconds}", published, tolerance)
      for seconds, published, tolerance in ((1, 0.108, 0.03), (5, 0.0435, 0.03), (10, 0.028, 0.04), (30, 0.0159, 0.25),
                                            (120, 0.0034, 0.05))),
    *(Row(f"Table 1, measured: {seconds} s", TIMES, f"std @ duration_s={seconds}", published, tolerance)
      for seconds, published, tolerance in ((1, 0.108, 0.15), (5, 0.0435, 0.2), (10, 0.028, 0.3))),
    Row("mean of all, deg/h", TIMES, "rate @ duration_s=120", 12.335042, 0.001),
    Row("two positions: heading, deg",
        TURNED, "/channels/0/north/heading", 70, 0.001),
    Row("LN-90A, 4 min: mean", f"rate gl1.npz --bias -0.0948 --interval 240 --methods mean {GL1} --csv -",
        "std @ method=mean", 0.0022, 0.35),
    Row("the same: optimal", f"rate gl1.npz --bias -0.0948 --interval 240 --methods optimal {GL1} --csv -",
        "std @ method=optimal", 0.00097, 0.35),
    Row("two positions: bias, deg/h", TURNED, "/channels/0/bias/value", -0.0948, 0.01, read=arcsec),
    Row("Table 2: the rate of an interval", READINGS, "rate @ interval=1 & method=optimal", 12.4392, 3e-4),
    Row("the conditional regression of 100 lines",
        f"rate gl1.npz --methods conditional --lines 100 --bias -0.0948 {GL1} --csv -",
        "std", 0.0018, 0.35),
    Row("the descent and the proven optimum agree, deg/h", (
        f"rate turned1.npz --methods staircase {GL1} --until 120 --certified --csv -",
        f"rate turned1.npz --methods staircase {GL1} --until 120 --csv -"), ("rate", "rate"), 0.0, 6e-5,
        read=lambda certified, found: certified - found),
    Row("a staircase without noise: its rate is certain",
        "rate quiet.npz --methods staircase --noise 'Q 0.0237 arcsec' --no-times --csv -", "rate", 12.4392, 1e-8),
)  # fmt: skip

TOLD = (
    Told("where averaging is right", "rate walk.npz --noise 'K 1 deg/h/sqrt(h)' --no-times --methods mean",
         "under this model the rate is measured without error"),
    Told("the best of the methods", f"rate gl1.npz --bias -0.0948 --methods mean,regression,optimal {GL1}",
         "use optimal: 2.11 times better than averaging"),
)  # fmt: skip

DRAWN = (
    Drawn("Figs. 3, 4, 5", f"rate turned1.npz --bias -0.0948 {GL1} --closeup fig.svg"),
    Drawn("Fig. 10", f"rate turned1.npz --bias -0.0948 {GL1} --plot fig.svg"),
    Drawn("Table 2", f"rate turned1.npz --bias -0.0948 {GL1} --readings fig.csv"),
)
