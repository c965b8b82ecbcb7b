"""Published degrees of freedom and bias factors, and their errors as docs/published_formulas.md states them."""

from table import Page

import functools
from itertools import chain, product

import numpy as np
import pytest
from allantools.ci import edf_greenhall
from scipy.integrate import quad
from tests import ROOT, model_of
from tests.reference import edf as published
from tests.reference.dense import moments, quadratic_form
from tests.reference.laws import LAWS, STRUCTURES, exact_edf
from tests.rows import refused, rows

import allanite as al
from allanite.statistics import STATISTICS, edf
from allanite.statistics.confidence.bias import published_bias
from allanite.statistics.confidence.powerlaw import symbol_of

PAGE = Page((ROOT / "docs" / "published_formulas.md").read_text(encoding="utf-8"))
SIZE = 256
NAMES = {2: "WPM", 1: "FPM", 0: "WFM", -1: "FFM", -2: "RWFM", -3: "FWFM", -4: "RRFM"}
RANGES = {"1": (1,), "2 to 8": (2, 4, 8), "16 to 64": (16, 32, 64), "85 to 128": (85, 103, 127, 128)}
THEO_RANGES = {"10 to 64": (10, 16, 32, 64), "86 to 128": (86, 128), "160 to 256": (160, 192, 200, 240, 256)}


def greenhall_riley(**case):
    return lambda alpha, m, N: published.greenhall_riley(alpha, m=m, N=N, **case)


FORMULAS = {
    # heading of the page: statistic, formula, alphas, ranges of m
    "Greenhall & Riley, adev": ("adev", greenhall_riley(d=2, overlapped=False), range(2, -3, -1), RANGES),
    "Greenhall & Riley, oadev": ("oadev", greenhall_riley(d=2), range(2, -3, -1), RANGES),
    "Greenhall & Riley, mdev and tdev": ("mdev", greenhall_riley(d=2, modified=True), range(2, -3, -1), RANGES),
    "Greenhall & Riley, hdev": ("hdev", greenhall_riley(d=3, overlapped=False), range(2, -5, -1), RANGES),
    "Greenhall & Riley, ohdev": ("ohdev", greenhall_riley(d=3), range(2, -5, -1), RANGES),
    "Older closed forms, oadev": ("oadev", published.overlapped_allan, range(2, -3, -1), RANGES),
    "Total deviation": ("totdev", published.total, range(0, -3, -1), RANGES),
    "Modified total deviation": ("mtotdev", published.modified_total, range(2, -3, -1), RANGES),
    "Hadamard total deviation": ("htotdev", published.hadamard_total, range(0, -5, -1), RANGES),
    "Theo1": ("theo1", published.theo1, range(2, -3, -1), THEO_RANGES),
}


def inside(name, ranges):
    """Averaging factors of the ranges, by their label, that the statistic allows."""
    most = STATISTICS[name].largest(SIZE)
    return {label: [m for m in factors if m <= most] for label, factors in ranges.items()}


@rows("heading", [name for name in FORMULAS if not name.startswith("Older")])
def test_the_package_has_the_same_formulas(heading):
    name, formula, alphas, ranges = FORMULAS[heading]
    for alpha, m, size in product(alphas, chain(*inside(name, ranges).values()), (SIZE + 1, 5 * SIZE + 1)):
        assert STATISTICS[name].published_edf(alpha, m, size) == pytest.approx(formula(alpha, m, size), rel=1e-9)


@functools.cache
def exact(name, alpha, m):
    return exact_edf(STATISTICS[name], alpha, m, SIZE)


def stated(cell):
    """The smallest and the largest error in % that a cell of the page states."""
    return [float(number) for number in cell.split(" .. ")]


@pytest.mark.nightly("errors of formulas that are printed in books")
@rows("heading", list(FORMULAS))
def test_the_page_states_the_error_of_every_formula(heading):
    name, formula, alphas, ranges = FORMULAS[heading]
    rows = PAGE.rows(heading + "\n")
    assert list(rows[0]) == ["noise", *(f"m = {label}" for label in ranges)]
    for alpha, row in zip(alphas, rows, strict=True):
        assert row["noise"] == NAMES[alpha]
        for label, factors in inside(name, ranges).items():
            found = [100 * (formula(alpha, m, SIZE + 1) / exact(name, alpha, m) - 1) for m in factors]
            # rounded to whole percents
            assert stated(row[f"m = {label}"]) == pytest.approx([min(found), max(found)], abs=0.51)


@pytest.mark.slow("seconds of analyses")
@rows("heading", list(FORMULAS))
def test_the_package_has_the_exact_values(heading):
    name, _, alphas, ranges = FORMULAS[heading]
    row, factors = STATISTICS[name], [*chain(*inside(name, ranges).values())]
    for alpha in set(alphas) & {2, 0, -1, -2}:
        found = edf(row, model_of({symbol_of(alpha): 1.0}), np.array(factors), SIZE, 1.0)
        # as `edf` promises: windows are thinned out where they are many
        tolerance = 1e-5 if row.differences else 1e-2
        np.testing.assert_allclose(found, [exact(name, alpha, m) for m in factors], rtol=tolerance)


GOLDEN = (
    (2, {}, ((0, 1, 199.77), (0, 8, 41.13), (0, 64, 4.02), (0, 127, 1.02), (-2, 8, 28.14), (-2, 64, 2.25),
             (2, 1, 131.41), (2, 64, 89.07), (1, 8, 68.88))),
    (2, {"modified": True}, ((2, 8, 37.57), (0, 8, 28.88), (-2, 8, 22.78))),
    (3, {}, ((0, 8, 33.89), (-2, 8, 28.67), (-4, 8, 22.63))),
)  # fmt: skip
"""Theory of the overlapped Allan (d = 2), modified and Hadamard (d = 3) variance, 257 points: alpha, m, degrees."""


def test_golden_values():
    for d, case, known in GOLDEN:
        for alpha, m, value in known:
            found = published.greenhall_riley(alpha, d, m=m, N=257, **case)
            assert found == pytest.approx(value, abs=0.005), (d, alpha, m)


@rows("d", [1, 2, 3])
@rows("alpha", list(LAWS))
@rows("modified", [False, True])
@rows("overlapped", [False, True])
def test_another_implementation_agrees(d, alpha, modified, overlapped):
    if alpha + 2 * d <= 1:
        refused(AssertionError, "does not exist", lambda: published.greenhall_riley(alpha, d, 1, 1000))
        return
    for m in (1, 2, 5, 10, 30, 100, 240):
        case = {"modified": modified, "overlapped": overlapped}
        own = published.greenhall_riley(alpha, d, m, 1000, **case)
        assert own > 0
        if lacking(alpha, d, m, **case):
            continue
        other = edf_greenhall(alpha, d, m, 1000, overlapping=overlapped, modified=modified)
        assert own == pytest.approx(other, rel=1e-9)


def lacking(alpha, d, m, *, modified, overlapped):
    """Branches that the other one has not got: white noise of the angle at long tau, alpha = -4 of table 2."""
    if modified or m == 1:
        return False
    r = (1 + (m if overlapped else 1) * (1000 - 1 - m * d) // m) / (m if overlapped else 1)
    return (alpha == 2 and r <= d) or (alpha == -4 and min(r, d + 1) * (m if overlapped else 1) > 100 and r >= d + 1)


@rows("d", [1, 2, 3])
@rows("alpha", [0, -1, -2, -3, -4])
def test_table_2_is_an_integral(alpha, d):
    """a0 = int rho^2 dt over (-d-1, d+1), a1 = 2 int t rho^2 dt over (0, d+1) with rho = s_z(t)/s_z(0)."""
    if published.GR_TABLE_2[alpha][d - 1] is None:
        return

    def squared(t):
        return (published.s_z(t, float("inf"), alpha, d) / published.s_z(0, float("inf"), alpha, d)) ** 2

    pieces = [(k, k + 1) for k in range(d + 1)]
    a0 = 2 * sum(quad(squared, *piece)[0] for piece in pieces)
    a1 = 2 * sum(quad(lambda t: t * squared(t), *piece)[0] for piece in pieces)
    assert published.GR_TABLE_2[alpha][d - 1] == pytest.approx((a0, a1), abs=6e-4)


def test_flicker_at_one_sample_needs_its_square_and_theo1_of_random_walk_turns_negative():
    """A copy of the older form that leaves the square out gives 0.9 degrees of freedom where there are 225."""
    assert published.overlapped_allan(-1, 1, 257) == pytest.approx(exact("oadev", -1, 1), rel=0.02)
    assert published.theo1(-2, 240, 257) < 0 < exact("theo1", -2, 240)


# bias

PUBLISHED_BIAS = {name: row.published for name, row in STATISTICS.items() if row.published}
BIAS_RANGES = {"m = 1": (1,), "2 to 8": (2, 4, 8), "10 to 64": (10, 16, 32, 64), "66 to 128": (66, 96, 128),
               "beyond n/2": (160, 192, 240)}  # fmt: skip
BIASED = [(name, alpha) for name in ("totdev", "mtotdev", "htotdev", "theo1")
          for alpha in PUBLISHED_BIAS[name].coefficients]  # fmt: skip


def exact_bias(name, alpha, m):
    """E[estimate] / E[target]; the target of Theo1 and of the total deviation is the Allan variance at any tau."""
    row, law = STATISTICS[name], LAWS[alpha]
    expected = moments(quadratic_form(row, m, SIZE), [law])[0][0]
    if row.target != "oadev":
        return expected / moments(quadratic_form(STATISTICS[row.target], m, SIZE), [law])[0][0]
    t = np.array([1.0, 2.0]) * m * row.tau_factor
    D = STRUCTURES[alpha](t)
    return expected / ((4 * D[0] - D[1]) / (2 * t[0] ** 2))


@pytest.mark.nightly("errors of formulas that are printed in books")
@rows("name, alpha", BIASED)
def test_the_page_states_the_error_of_every_factor(name, alpha):
    (row,) = (row for row in PAGE.rows("Bias") if (row["statistic"], row["noise"]) == (name, NAMES[alpha]))
    for cell, factors in zip(list(row.values())[2:], inside(name, BIAS_RANGES).values(), strict=True):
        m = np.array([k for k in factors if name != "theo1" or k >= 10], dtype=int)
        factor = published_bias(STATISTICS[name], alpha, m, SIZE) if m.size else m
        found = [100 * (one / exact_bias(name, alpha, k) - 1) for one, k in zip(factor, m.tolist(), strict=True)]
        assert (cell == "-") == (not found)
        assert not found or stated(cell) == pytest.approx([min(found), max(found)], abs=0.051)


def test_what_is_not_published():
    """As the page says: high by 1.34 tau/T and up to 1.38."""
    assert exact_bias("totdev", 2, 128) == pytest.approx((1 + 1.34 / 2), abs=0.005)
    assert exact_bias("htotdev", 2, 64) == pytest.approx(1.38, abs=0.005)
    for name, alpha in (("totdev", 2), ("htotdev", 1), ("theo1", -3)):
        with pytest.raises(al.UsageError):
            published_bias(STATISTICS[name], alpha, np.array([4, 8]), SIZE)


def test_every_tau_may_have_its_own_noise_and_other_rows_have_no_bias():
    alphas, m = np.array([2, 0, -2]), np.array([2, 4, 8])
    for name in set(STATISTICS) - set(PUBLISHED_BIAS):
        np.testing.assert_array_equal(published_bias(STATISTICS[name], alphas, m, SIZE), 1.0, name)
    for name in ("mtotdev", "ttotdev"):
        assert published_bias(STATISTICS[name], alphas, m, SIZE).tolist() == [0.94, 0.73, 0.69]
    alphas, m = np.array([-1, -1, 0]), np.array([1, 2, 10])
    assert published_bias(STATISTICS["htotdev"], alphas, m, SIZE).tolist() == [1.0, 0.851, 0.995]


def test_the_argument_of_theo1_is_tau_and_not_m():
    """With m instead of 0.75 m the worst error from m = 10 on is what the page says."""
    row, wrong = PUBLISHED_BIAS["theo1"], {}
    for alpha, c in row.coefficients.items():
        for m in (10, 16, 64, 256):
            wrong[alpha, m] = row.factor(c, np.array([m / 0.75]), SIZE)[0] / exact_bias("theo1", alpha, m) - 1
    assert max(map(abs, wrong.values())) == pytest.approx(0.15, abs=0.005)
