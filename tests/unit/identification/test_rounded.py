"""Rounding errors of an angle that moves too little between readings are not taken for quantization noise."""

from dataclasses import replace

import numpy as np
import pytest

import allanite as al


def rounded(Q, rng=1, size=4096):
    model = al.Q(Q, "arcsec") + al.N(1, "deg/sqrt(h)")
    return al.simulate(model, size, 1.0, rng=np.random.default_rng(rng), rounding=True)


@pytest.mark.parametrize("lost", [False, True])
def test_an_angle_that_hardly_moves_between_readings_tells_no_quantization(lost):
    record = rounded(60)
    if lost:
        values = np.array(record.values)
        values[1000:1100] = np.nan
        record = replace(record, values=values)
    fit = al.identify(record)
    assert [fit[s].status for s in "QN"] == ["not valid", "not valid"]
    assert "of the step it is rounded to between readings" in fit["Q"].reason
    assert fit.validity == "approximate"


def test_one_that_moves_enough_does():
    fit = al.identify(rounded(30))
    low, high = fit["Q"].interval()
    assert low < al.Q(30, "arcsec").value < high


def test_gaussian_noise_of_the_angle_has_no_step():
    model = al.Q(60, "arcsec") + al.N(1, "deg/sqrt(h)")
    assert al.identify(al.simulate(model, 4096, 1.0, rng=np.random.default_rng(1)))["Q"].claimed
