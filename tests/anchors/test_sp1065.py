"""Published values: NIST Special Publication 1065 (W. J. Riley, 2008), tables 30 to 32, and its 1000-point set."""

import numpy as np
import pytest

import allanite as al

NBS14 = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0]

PUBLISHED = [
    # data, statistic, m, deviation as printed
    ("nbs14", "adev", 1, "91.22945"),
    ("nbs14", "adev", 2, "115.8082"),
    ("nbs14", "oadev", 1, "91.22945"),
    ("nbs14", "oadev", 2, "85.95287"),
    ("lcg", "adev", 1, "2.922319e-1"),
    ("lcg", "adev", 10, "9.965736e-2"),
    ("lcg", "adev", 100, "3.897804e-2"),
    ("lcg", "oadev", 1, "2.922319e-1"),
    ("lcg", "oadev", 10, "9.159953e-2"),
    ("lcg", "oadev", 100, "3.241343e-2"),
]


def lcg():
    """n_0 = 1234567890, n_{i+1} = 16807 n_i mod 2147483647; y = n / 2147483647."""
    n, values = 1234567890, []
    for _ in range(1000):
        values.append(n / 2147483647)
        n = 16807 * n % 2147483647
    return np.array(values)


DATA = {"nbs14": np.array(NBS14), "lcg": lcg()}


def test_the_generator_is_the_published_one():
    assert round(DATA["lcg"].mean(), 9) == 0.489774463
    assert round(DATA["lcg"].std(ddof=1), 7) == 0.2884664


@pytest.mark.parametrize(("data", "statistic", "m", "printed"), PUBLISHED)
def test_every_printed_digit(data, statistic, m, printed):
    record = al.Record(DATA[data], rate=1.0, unit="1", kind="rate")
    found = al.deviation(record, statistic, m=[m]).deviation[0]
    digits = len(printed.split("e")[0].replace(".", ""))
    assert f"{found:.{digits - 1}e}" == f"{float(printed):.{digits - 1}e}"


GOLDEN_EDF = [
    # (size, m), degrees of freedom of Q, N, B, K and of all four in equal shares; from the literal sum over all lags
    ((256, 1), (131.4079, 170.2225, 224.7336, 226.7655, 219.7272)),
    ((256, 8), (126.0955, 45.0611, 35.7201, 28.2479, 63.1525)),
    ((256, 64), (89.0687, 4.0194, 3.0161, 2.2494, 5.6898)),
    ((3600000, 1000), (1850665.04, 5397.7449, 4204.1564, 3336.2112, 8789.8083)),
    ((3600000, 360000), (1582901.3, 12.8000, 9.9117, 7.7475, 20.3578)),
]


@pytest.mark.parametrize(("where", "expected"), GOLDEN_EDF)
def test_degrees_of_freedom(where, expected):
    from allanite.statistics import STATISTICS, edf

    size, m = where
    one = [al.Model((al.Q(1, "s"),)), al.Model((al.N(1, "sqrt(s)"),)), al.Model((al.B(1, "1"),))]
    one.append(al.Model((al.K(1, "1/sqrt(s)"),)))
    level = [np.sqrt(al.expected(model, "oadev", m)[0]) for model in one]
    equal = al.Q(1 / level[0], "s") + al.N(1 / level[1], "sqrt(s)") + al.B(1 / level[2], "1")
    equal += al.K(1 / level[3], "1/sqrt(s)")
    found = [edf(STATISTICS["oadev"], model, np.array([m]), size, 1.0)[0] for model in (*one, equal)]
    np.testing.assert_allclose(found, expected, rtol=3e-7, atol=5e-5)
