"""001, Tang, Cheng, Gao: Theo1, TheoBR and TheoH."""

import math

from tests.conformance.papers.direct import allan, kf, stability, theo1
from tests.conformance.papers.rows import Row, ratio


def over_the_variance(long, short):
    """A deviation at 450 s over that of white noise with the variance of the readings, squared."""
    return 450 * (long / short) ** 2


ROWS = (
    Row("means of 10 s", "analyze white.npz --terms N --coefficients -", "value @ name=10 s stability",
        lambda: stability("white.npz", 10), 1e-6),
    Row("eq. 3", "deviation white.npz --statistic adev --m 100 --no-intervals --csv -", "deviation",
        lambda: allan("white.npz", 100), 1e-9),
    Row("the same, overlapping, %", "explain oadev --samples 7200 --taus 100 --csv -", "edf N", 6.9, 0.01,
        read=lambda edf: 100 / math.sqrt(2 * edf)),
    *(Row(f"eq. 6, m = {m}", f"deviation white.npz --statistic theo1 --m {m} --no-intervals --csv -", "deviation",
          lambda m=m: theo1("white.npz", m), 1e-9) for m in (10, 1000, 7200)),
    Row("the same, with the bias of the model",
        "deviation fog.npz --statistic theoh,oadev --taus 1440,1500 --bias model --csv -",
        ("deviation @ statistic=theoh & tau_s=1500", "deviation @ statistic=oadev & tau_s=1500"), 1.0, 0.03,
        read=ratio),
    Row("joint at 10 % of the record",
        "deviation fog.npz --statistic theoh,theobr --join 0.1 --no-intervals --taus 1080 --csv -",
        ("deviation @ statistic=theoh", "deviation @ statistic=theobr"), 1.0, 1e-9, read=ratio),
    *(Row(f"five terms of TheoH by {method}: {symbol}",
          f"analyze fog.npz --method {method} --statistic theoh --taus octave --coefficients -",
          f"value @ term={symbol}", true, tolerance)
      for method, tolerances in (("nnls", (0.2, 0.4, 0.2)), ("gls", (0.1, 0.2, 0.2)))
      for symbol, true, tolerance in zip("NBR", (0.02, 0.3, 5.0), tolerances, strict=True)),
    Row("means first: N", "analyze fog.npz --average 10 --coefficients -", "value @ term=N", 0.02, 0.2),
    *(Row(f"eq. 9: the ratio that removes the bias of {kind}",
          f"deviation {kind}.npz --statistic theobr,theo1 --bias plain --m 600 --no-intervals --csv -",
          ("deviation @ statistic=theobr", "deviation @ statistic=theo1"), lambda kind=kind: kf(f"{kind}.npz"), 1e-9,
          read=ratio) for kind in ("brief", "fog")),
    *(Row(f"eq. 13, longest time: {name} 90 % limit, %",
          "deviation white.npz --terms N --statistic theo1 --m 7200 --level 0.9 --csv -", (name, "deviation"), limit,
          0.02, read=lambda end, middle: 100 * (end / middle - 1)) for name, limit in (("low", -42), ("high", 155))),
    Row("in varying noise Allan has no bias", "deviation bump.npz --statistic oadev --m 1,450 --no-intervals --csv -",
        ("rms deviation @ m=450", "rms deviation @ m=1"), 1.0, 0.1, 1.273, wrong=True, read=over_the_variance),
    Row("in varying noise Theo1 has some: 20 % in 60 records",
        ("deviation bump.npz --statistic theo1 --m 600 --no-intervals --csv -",
         "deviation bump.npz --statistic oadev --m 1,450 --no-intervals --csv -"),
        ("rms deviation", "rms deviation @ m=1"), 1.2, 0.02, read=over_the_variance),
)  # fmt: skip
