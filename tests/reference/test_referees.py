"""The referees against each other: two ways to one number, where they are defined, and what may not change them."""

import numpy as np
import pytest

from tests.reference import REFEREES, factors, largest
from tests.reference.terms import UndefinedError, phase
from tests.reference.theo import kf
from tests.reference.windows import WINDOWS, windowed
from tests.rows import paired, rows

LARGEST = {
    # from the index ranges of the definitions, n intervals
    "adev": lambda n: n // 2,
    "oadev": lambda n: n // 2,
    "mdev": lambda n: (n + 1) // 3,
    "tdev": lambda n: (n + 1) // 3,
    "hdev": lambda n: n // 3,
    "ohdev": lambda n: n // 3,
    "totdev": lambda n: n if n > 1 else 0,
    "mtotdev": lambda n: (n + 1) // 3,
    "ttotdev": lambda n: (n + 1) // 3,
    "htotdev": lambda n: n // 3,
    "theo1": lambda n: n // 2 * 2,
    "theobr": lambda n: n // 2 * 2 if n >= 89 else 0,
    "theoh": lambda n: n // 2 * 2 if n >= 89 else n // 5,
    "pdev": lambda n: n // 2,
    "mtie": lambda n: n,
    "tierms": lambda n: n,
    "haar": lambda n: 2 ** ((n // 2).bit_length() - 1) if n > 1 else 0,
}


def white(n, seed=1, dtype=float):
    return np.random.default_rng(seed).standard_normal(n).astype(dtype)


@rows("n, name", paired([*range(1, 14), 31, 88, 89, 90], REFEREES))
def test_the_largest_factor_is_that_of_the_index_ranges(name, n):
    assert largest(name, n) == LARGEST[name](n)


@rows("name", WINDOWS)
@rows("n", [3, 12, 31])
def test_windows_of_the_rate_say_the_same_as_the_phase(name, n):
    y = white(n)
    for m in factors(name, n):
        assert windowed(y, m, name)[0] == pytest.approx(REFEREES[name](phase(y), m, 1.0), rel=1e-12)


@rows("name", WINDOWS)
@rows("lost", [[0], [118], [11, 55], [7, 8, 9, 70]])
def test_a_lost_sample_takes_every_window_that_touches_it(name, lost):
    """The mean over the phase referee's values of single windows, of those that no NaN reaches."""
    y = white(120, seed=2)
    y[lost] = np.nan
    stride, width = WINDOWS[name][2:]
    for m in {1, 2, 4, 6} & set(factors(name, 120)):
        starts = range(0, 121 - width(m), stride(m))
        single = np.array([REFEREES[name](phase(y[i : i + width(m)]), m, 1.0) for i in starts])
        left = np.isfinite(single)
        variance, count = windowed(y, m, name)
        assert 0 < count == left.sum() < left.size
        assert variance == pytest.approx(single[left].mean(), rel=1e-12)


def test_adev_keeps_the_blocks_before_and_after_a_gap():
    y = np.array([1.0, 3.0, 2.0, 2.0, np.nan, 5.0, 6.0, 8.0, 1.0, 1.0])
    variance, count = windowed(y, 2, "adev")
    assert count == 2  # blocks 2 2 . 7 1: two pairs of neighbours are complete
    assert variance == (0**2 + 6**2) / 2 / 2


@rows("name", REFEREES)
def test_long_double_is_not_lost(name):
    x = phase(white(96, dtype=np.longdouble))
    for m in factors(name, 96)[:: 1 + len(factors(name, 96)) // 4]:
        found = REFEREES[name](x, m, np.longdouble(1) / 3)
        assert found.dtype == np.longdouble
        assert float(found) == pytest.approx(float(REFEREES[name](x.astype(float), m, 1 / 3)), rel=1e-12)


CONSTANT_RATE = [name for name in REFEREES if name not in ("mtie", "tierms")]


@rows("name", CONSTANT_RATE)
def test_a_constant_rate_changes_nothing(name):
    x = phase(white(100, seed=3, dtype=np.longdouble))
    line = 7 - 5 * np.arange(101, dtype=np.longdouble)
    for m in factors(name, 100):
        before, after = REFEREES[name](x, m, 0.1), REFEREES[name](x + line, m, 0.1)
        assert float(after) == pytest.approx(float(before), rel=1e-14)


DRIFT = ("hdev", "ohdev", "htotdev")


@rows("name", DRIFT)
def test_a_ramp_is_nothing_to_hadamard(name):
    x = phase(np.arange(30.0))
    for m in factors(name, 30):
        assert REFEREES[name](x, m, 1.0) == pytest.approx(0, abs=1e-20)


def test_relations_that_hold_exactly():
    x = phase(white(97, seed=4))
    of = {name: lambda m, name=name: REFEREES[name](x, m, 1.0) for name in REFEREES}
    assert of["mdev"](1) == pytest.approx(of["oadev"](1))
    assert of["totdev"](1) == pytest.approx(of["oadev"](1))
    assert of["mtotdev"](1) == pytest.approx(of["oadev"](1) / 2)
    assert of["pdev"](1) == of["oadev"](1)
    for m in (1, 2, 4, 8, 16, 32):
        assert of["haar"](m) == pytest.approx(of["oadev"](m) / 2)
        assert of["ttotdev"](m) == pytest.approx(m**2 * of["mtotdev"](m) / 3)


def test_theoh_has_no_point_between_its_two_halves():
    n = 100
    assert factors("theoh", n) == [*range(1, 21), *range(28, 101, 2)]  # 20 = 0.2 * 100; 0.75 * 28 = 21
    x = phase(white(n))
    assert REFEREES["theoh"](x, 20, 1.0) == REFEREES["oadev"](x, 20, 1.0)
    assert REFEREES["theoh"](x, 28, 1.0) == REFEREES["theobr"](x, 28, 1.0)


def test_the_divisor_six_has_no_last_term_where_six_divides_the_number_of_points():
    assert kf(phase(white(100)), 1.0, 6) > 0
    with pytest.raises(UndefinedError):
        kf(phase(white(101)), 1.0, 6)  # 102 points: Allan at m = 51 needs 103
