"""Splines are those of scipy.interpolate, the referee."""

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from allanite.core.splines import basis, cubic, linear, valued


def test_splines_through_points_are_those_of_scipy() -> None:
    rng = np.random.default_rng(1)
    for n in (2, 3, 4, 5, 40):
        x, y = np.cumsum(rng.uniform(0.1, 1.0, n)), rng.standard_normal((2, 3, n))
        at = np.linspace(x[0] - 0.2, x[-1] + 0.2, 99)
        for own, referee in ((cubic, CubicSpline(x, y, axis=-1)), (linear, make_interp_spline(x, y, 1, axis=-1))):
            np.testing.assert_allclose(valued(x, own(x, y), at), referee(at), rtol=1e-10, atol=1e-12)
            np.testing.assert_allclose(valued(x, own(x, y[1, 2]), at), referee(at)[1, 2], rtol=1e-10, atol=1e-12)


def test_basis_splines_are_those_of_scipy() -> None:
    knots = np.array([0.0] * 4 + [0.7, 1.4, 5.0, 8.0] + [9.0] * 4)
    x = np.concatenate((knots[3:-4], np.linspace(0.0, 9.0 - 1e-9, 200)))
    np.testing.assert_allclose(basis(knots, x), BSpline.design_matrix(x, knots, 3).toarray(), atol=1e-14)
