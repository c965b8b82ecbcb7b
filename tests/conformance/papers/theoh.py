"""001, Tang, Cheng, Gao: Theo1, TheoBR and TheoH."""

from tests.conformance.papers.direct import allan, kf, stability, theo1
from tests.conformance.papers.inputs import FOG
from tests.conformance.papers.rows import Drawn, Row, Told, percent, ratio, rms

EXPLAIN = "explain theo1 --samples 7200 --taus 9,75,540,750,1080,2700,4050,5400 --csv -"
BIAS = {"B": (1.685, 1.835, 1.864), "K": (2.464, 2.661, 2.694), "Q": (0.397, 0.222, 0.142)}
EDF = {100: 387, 720: 51.6, 1440: 24.2, 3600: 7.8, 5400: 4.2, 7200: 2.4}


def over_the_variance(long, short):
    """A deviation at 450 s over that of white noise with the variance of the readings, squared."""
    return 450 * (rms(long) / rms(short)) ** 2


ROWS = (
    Row("means of 10 s", "analyze white.npz --terms N --coefficients -", "value @ name=10 s stability",
        lambda: stability("white.npz", 10), 1e-6),
    Row("eq. 3", "deviation white.npz --statistic adev --m 100 --no-intervals --csv -", "deviation",
        lambda: allan("white.npz", 100), 1e-9),
    Row("eq. 5: error of 72 groups, %", "explain adev --samples 7200 --taus 100 --csv -", "edf N",
        8.40, 0.05, 10.25, wrong=True, read=percent),
    Row("the same, overlapping, %", "explain oadev --samples 7200 --taus 100 --csv -", "edf N", 6.9, 0.01,
        read=percent),
    *(Row(f"eq. 6, m = {m}", f"deviation white.npz --statistic theo1 --m {m} --no-intervals --csv -",
          "deviation",
          lambda m=m: theo1("white.npz", m), 1e-9) for m in (10, 1000, 7200)),
    Row("longest averaging time, s", "deviation fog.npz --statistic theo1 --taus all --no-intervals --csv -",
        "tau_s @ last", 5400, 0.0),
    Row("that of Allan, s", "deviation fog.npz --statistic adev --taus all --no-intervals --csv -",
        "tau_s @ last", 3600, 0.0),
    *(Row(f"Table 1: {symbol}, m = {m}", EXPLAIN, f"ratio {symbol} @ m={m}", published, 0.04)
      for symbol, row in BIAS.items() for m, published in zip((12, 100, 1000), row, strict=True)),
    *(Row(f"Table 2: N, m = {m}", EXPLAIN, f"edf N @ m={m}", published, 0.17 if m == 7200 else 0.1)
      for m, published in EDF.items()),
    Row("Table 2: N, m = 10", "deviation white.npz --terms N --statistic theo1 --m 10 --csv -", "edf", 3139,
        0.1),
    Row("Table 2: K, m = 7200", EXPLAIN, "edf K @ m=7200", -0.27, 0.1, 1.05, wrong=True),
    Row("TheoH has no bias",
        f"deviation --model '{FOG}' --rate 1 --duration '2 h' --statistic theoh,oadev --taus 1500 --csv -",
        ("deviation @ statistic=theoh", "deviation @ statistic=oadev"), 1.0, 0.05, 0.859, wrong=True, read=ratio),
    Row("the same, with the bias of the model",
        "deviation fog.npz --statistic theoh,oadev --taus 1440,1500 --bias model --csv -",
        ("deviation @ statistic=theoh & tau_s=1500", "deviation @ statistic=oadev & tau_s=1500"), 1.0, 0.03,
        read=ratio),
    Row("joint at 10 % of the record",
        "deviation fog.npz --statistic theoh,theobr --join 0.1 --no-intervals --taus 1080 --csv -",
        ("deviation @ statistic=theoh", "deviation @ statistic=theobr"), 1.0, 1e-9, read=ratio),
    Row("eq. 13: lower 90 % limit, %",
        "deviation white.npz --terms N --statistic theo1 --m 720 --level 0.9 --csv -",
        ("low", "deviation"), -13.5, 0.05, read=lambda low, middle: 100 * (low / middle - 1)),
    Row("eq. 13: upper 90 % limit, %",
        "deviation white.npz --terms N --statistic theo1 --m 720 --level 0.9 --csv -",
        ("high", "deviation"), 19, 0.05, read=lambda high, middle: 100 * (high / middle - 1)),
    Row("eq. 12", "deviation white.npz --terms N --statistic theo1 --m 720 --edf published --power-law --csv -",
        "edf", 51.6, 0.01),
    Row("Fig. 3: the noise at each time",
        "deviation white.npz --terms N --statistic theo1 --m 720 --edf published --power-law --csv -",
        "alpha", 0.0, 0.0),
    *(Row(f"five terms of TheoH: {symbol}",
          "analyze fog.npz --method nnls --statistic theoh --taus octave --coefficients -",
          f"value @ term={symbol}", true, tolerance)
      for symbol, true, tolerance in (("N", 0.02, 0.2), ("B", 0.3, 0.4), ("R", 5.0, 0.2))),
    *(Row(f"the same by gls: {symbol}",
          "analyze fog.npz --method gls --statistic theoh --taus octave --coefficients -",
          f"value @ term={symbol}", true, tolerance)
      for symbol, true, tolerance in (("N", 0.02, 0.1), ("B", 0.3, 0.2), ("R", 5.0, 0.2))),
    Row("means first: N", "analyze fog.npz --average 10 --coefficients -", "value @ term=N", 0.02, 0.2),
    Row("eq. 9: the ratio that removes the bias",
        "deviation brief.npz --statistic theobr,theo1 --m 600 --no-intervals --csv -",
        ("deviation @ statistic=theobr", "deviation @ statistic=theo1"), lambda: kf("brief.npz"), 1e-9, read=ratio),
    *(Row(f"eq. 13, longest time: {name} 90 % limit, %",
          "deviation white.npz --terms N --statistic theo1 --m 7200 --level 0.9 --csv -", (name, "deviation"), limit,
          0.02, read=lambda end, middle: 100 * (end / middle - 1)) for name, limit in (("low", -42), ("high", 155))),
    Row("in varying noise Allan has no bias", "deviation bump.npz --statistic oadev --m 1,450 --no-intervals --csv -",
        ("all deviation @ m=450", "all deviation @ m=1"), 1.0, 0.1, 1.273, wrong=True,
        read=over_the_variance),
    Row("in varying noise Theo1 has some: 20 %",
        ("deviation bump.npz --statistic theo1 --m 600 --no-intervals --csv -",
         "deviation bump.npz --statistic oadev --m 1,450 --no-intervals --csv -"),
        ("all deviation", "all deviation @ m=1"), 1.2, 0.02, read=over_the_variance),
    *(Row(f"Table 3: {symbol}, error with Theo1 over that with Allan, no gain", (
          "analyze fogs.npz --method nnls --statistic theo1 --taus octave --coefficients -",
          "analyze fogs.npz --method nnls --statistic oadev --taus octave --coefficients -"),
          (f"all value @ term={symbol}",) * 2, 1.0, 0.3, ours, read=lambda theo, allan, true=true: (
          rms(v - true for v in theo) / rms(v - true for v in allan)))
      for symbol, true, ours in (("B", 0.3, None), ("K", 1.0, None), ("R", 5.0, None))),
)  # fmt: skip

TOLD = (
    Told("the jump of TheoH", "deviation fog.npz --statistic theoh --taus octave --bias plain", "theoh jumps there"),
    Told("Fig. 6", "analyze step.npz", "the noise level changes by a factor of 3"),
)

DRAWN = (
    Drawn("Fig. 5", "deviation white.npz --statistic adev,theo1 --taus all --no-intervals --plot fig.svg"),
    Drawn("Fig. 7", "deviation step.npz --statistic adev,theo1 --taus log --no-intervals --plot fig.svg"),
    Drawn("Fig. 9", "deviation fog.npz --statistic adev,theo1,theobr,theoh --taus log --no-intervals --plot fig.svg"),
)
