"""003, Enin, Saneev: the rate of a laser gyro in minutes."""

from tests.conformance.papers.rows import Row, arcsec

GL1 = "--latitude 55.7936 --noise 'N 0.000291797 deg/sqrt(h), Q 0.254442 arcsec' --no-times"
TURNED = f"rate turned1.npz --second turned2.npz --horizontal --near 60 --methods optimal {GL1} --json -"

ROWS = (
    Row("two positions: heading, deg",
        TURNED, "/channels/0/north/heading", 70, 0.001),
    Row("two positions: bias, deg/h", TURNED, "/channels/0/bias/value", -0.0948, 0.01, read=arcsec),
    Row("the conditional regression of 100 lines",
        f"rate gl1.npz --methods conditional --lines 100 --bias -0.0948 {GL1} --csv -",
        "std", 0.0018, 0.35),
    Row("the search and the proven optimum agree, deg/h", (
        f"rate turned1.npz --methods staircase {GL1} --until 120 --certified --csv -",
        f"rate turned1.npz --methods staircase {GL1} --until 120 --csv -"), ("rate", "rate"), 0.0, 6e-5,
        read=lambda certified, found: certified - found),
    Row("the descent from the count ends near the regression, deg/h", (
        f"rate turned1.npz --methods staircase {GL1} --until 120 --descent 20 --csv -",
        f"rate turned1.npz --methods regression {GL1} --until 120 --csv -"), ("rate", "rate"), 0.0, 6e-4,
        read=lambda staircase, line: staircase - line),
    Row("240 s with reversal: standard error below 0.002, deg/h",
        f"rate turned1.npz --second turned2.npz --until 120 --methods mean {GL1} --csv -",
        "predicted @ method=optimal", 0.002, 0.35, ours=0.00114, wrong=True),
    Row("a staircase without noise: its rate is certain",
        "rate quiet.npz --methods staircase --noise 'Q 0.0237 arcsec' --no-times --csv -", "rate", 12.4392, 1e-8),
)  # fmt: skip
