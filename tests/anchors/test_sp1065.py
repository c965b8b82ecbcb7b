"""Published values: NIST Special Publication 1065 (W. J. Riley, 2008), tables 30 to 32, and its 1000-point set."""

import numpy as np
from tests.anchors.values import WHO, Data, disagreements, lcg, value
from tests.rows import rows

import allanite as al

NBS14 = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0]

PUBLISHED = [
    # data, statistic, m, deviations as printed
    ("nbs14", "adev", (1, 2), "91.22945 115.8082"),
    ("nbs14", "oadev", (1, 2), "91.22945 85.95287"),
    ("nbs14", "mdev", (1, 2), "91.22945 74.78849"),
    ("nbs14", "tdev", (1, 2), "52.67135 86.35831"),
    ("nbs14", "hdev", (1, 2), "70.80607 116.7980"),
    ("nbs14", "ohdev", (1, 2), "70.80607 85.61487"),
    ("nbs14", "totdev", (1, 2), "91.22945 93.90379"),
    ("nbs14", "mtotdev", (1, 2), "75.50203 75.83606"),
    ("nbs14", "ttotdev", (1, 2), "43.59112 87.56794"),
    ("nbs14", "htotdev", (1, 2), "70.80607 91.16396"),
    ("lcg", "adev", (1, 10, 100), "2.922319e-1 9.965736e-2 3.897804e-2"),
    ("lcg", "oadev", (1, 10, 100), "2.922319e-1 9.159953e-2 3.241343e-2"),
    ("lcg", "mdev", (1, 10, 100), "2.922319e-1 6.172376e-2 2.170921e-2"),
    ("lcg", "tdev", (1, 10, 100), "1.687202e-1 3.563623e-1 1.253382e+0"),
    ("lcg", "hdev", (1, 10, 100), "2.943883e-1 1.052754e-1 3.910860e-2"),
    ("lcg", "ohdev", (1, 10, 100), "2.943883e-1 9.581083e-2 3.237638e-2"),
    ("lcg", "totdev", (1, 10, 100), "2.922319e-1 9.134743e-2 3.406530e-2"),
    ("lcg", "mtotdev", (1, 10, 100), "2.418528e-1 6.499161e-2 2.287774e-2"),
    ("lcg", "ttotdev", (1, 10, 100), "1.396338e-1 3.752293e-1 1.320847e+0"),
    ("lcg", "htotdev", (1, 10, 100), "2.943883e-1 9.614787e-2 3.058103e-2"),
    ("lcg", "theo1", (10, 100, 1000), "1.075740e-1 3.178931e-2 5.052400e-3"),
]

PUBLISHED_BIAS = {
    # statistic: (published expectation of the raw variance over the true one, the m from which it is applied)
    "mtotdev": (0.73, 1),  # white rate noise
    "ttotdev": (0.73, 1),
    "htotdev": (0.995, 2),  # m = 1 is the overlapped Hadamard variance
}

PDEV = {
    # F. Vernotte, SigmaTheta 3.0, on the 1000-point set
    1: 0.292231878106752, 2: 0.2144523356425264, 4: 0.15618112158618463, 8: 0.11709745745448434,
    16: 0.06902958518983934, 32: 0.04974970773039839, 64: 0.03894741733071374, 128: 0.03086239274137211,
    256: 0.012447414341332683,
}  # fmt: skip


DATA = {"nbs14": Data.of_rate(NBS14), "lcg": Data.of_rate(lcg())}


def test_the_generator_is_the_published_one():
    assert (round(lcg().mean(), 9), round(lcg().std(ddof=1), 7)) == (0.489774463, 0.2884664)


@rows("data, statistic, m, printed", PUBLISHED)
def test_every_printed_digit(data, statistic, m, printed):
    bias, first = PUBLISHED_BIAS.get(statistic, (1, 1))
    for who in WHO:
        found = value(who, statistic, DATA[data], m) / np.where(np.array(m) < first, 1, bias) ** 0.5
        assert not disagreements(found, printed.split()), who


@rows("who", WHO)
def test_parabolic_deviation_of_sigmatheta(who):
    np.testing.assert_allclose(value(who, "pdev", DATA["lcg"], PDEV), list(PDEV.values()), rtol=2e-12)


GOLDEN_EDF = [
    # (size, m), degrees of freedom of Q, N, B, K and of all four in equal shares; from the literal sum over all lags
    ((256, 1), (131.4079, 170.2225, 224.7336, 226.7655, 219.7272)),
    ((256, 8), (126.0955, 45.0611, 35.7201, 28.2479, 63.1525)),
    ((256, 64), (89.0687, 4.0194, 3.0161, 2.2494, 5.6898)),
    ((3600000, 1000), (1850665.04, 5397.7449, 4204.1564, 3336.2112, 8789.8083)),
    ((3600000, 360000), (1582901.3, 12.8000, 9.9117, 7.7475, 20.3578)),
]


@rows("where, expected", GOLDEN_EDF)
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
