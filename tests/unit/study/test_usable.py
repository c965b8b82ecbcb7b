"""A model that does not explain its record is no model of the sensor: what goes on from it refuses it unless told."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.core.validity import UNEXPLAINED

RATE = 50.0
TRUTH = al.Model("N 0.5 deg/sqrt(h), B 30 deg/h, K 900 deg/h/sqrt(h)")
RECORD = al.simulate(TRUTH, 20_000, RATE, rng=4, name="gx")
FIT = al.identify(RECORD)
REJECTED = replace(FIT, checked=UNEXPLAINED)
TILT = al.Model("N 100 ug/sqrt(Hz)")

USES = {
    "plan": lambda noise: al.plan(noise, RATE, durations=(600.0,)),
    "bound": lambda noise: al.bound(noise, 5000, RATE),
    "simulate": lambda noise: al.simulate(noise, 500, RATE, rng=1),
    "selfcheck": lambda noise: al.selfcheck(noise, 500, RATE, records=2, rng=1),
    "state space": lambda noise: al.state_space(noise, RATE),
    "drift": al.drift,
    "export": lambda noise: al.export(noise, "statespace", rate=RATE),
    "rate": lambda noise: al.constant_rate.estimate(RECORD, "mean", model=noise),
    "rates": lambda noise: al.constant_rate.experiment(
        RECORD, noise, al.constant_rate.ExperimentSettings(interval=20.0, methods=("mean",))
    ),
    "ranking": lambda noise: al.constant_rate.rank(noise, size=500, rate=RATE),
    "prediction": lambda noise: al.constant_rate.predicted_standard_error("mean", noise, size=500, rate=RATE),
    "vertical": lambda noise: al.attitude.optimal_time_constant(noise, TILT, duration=600.0),
}
"""What takes a noise and goes on from it."""


@pytest.mark.slow("seconds of analyses")
@rows("use", USES)
def test_what_goes_on_from_a_noise_refuses_one_that_explains_nothing(use):
    for noise in (REJECTED, REJECTED.model):
        with pytest.raises(al.DataError, match="does not explain the record"):
            USES[use](noise)
    for noise in (FIT, REJECTED.model.usable(unexplained=True)):
        assert USES[use](noise) is not None


@pytest.mark.slow("seconds of analyses")
def test_pulses_of_a_dithered_ring_laser_have_no_model_from_the_samples():
    record = al.simulation.simulate_ring_laser(al.simulation.GL1, 12.4392, 24_000, 400.0, rng=3)
    with pytest.raises(al.DataError, match="does not explain the record"):
        al.constant_rate.estimate(record, "optimal", model=al.identify(record))


def test_what_is_not_valid_is_left_out_of_a_fit_and_its_model_is_refused():
    fit = FIT.invalid("the curve contradicts it", ("K",))
    assert "K" in {term.symbol for term in fit.model}
    assert [t.symbol for t in fit.usable()] == [t.symbol for t in fit.model if t.symbol != "K"]
    assert fit.usable() == fit.valid
    refused(al.DataError, "not valid in this model: K", lambda: al.bound(fit.model, 5000, RATE))
    assert al.bound(fit, 5000, RATE).names == al.bound(fit.usable(), 5000, RATE).names


def test_a_doubt_goes_where_the_model_goes_and_changes_nothing_else():
    model = REJECTED.model
    assert model.doubt
    assert model == FIT.model
    assert repr(model) == repr(FIT.model)
    copies = [pickle.loads(pickle.dumps(model)), al.Model.from_dict(model.to_dict()), replace(model), model.noise]
    copies += [model + al.W(1, "deg/h", time_constant=20), al.W(1, "deg/h", time_constant=20) + model]
    assert [copy.doubt for copy in copies] == [model.doubt] * len(copies)
    assert pickle.loads(pickle.dumps(REJECTED)).model.doubt == al.Fit.from_dict(REJECTED.to_dict()).model.doubt != ""
    assert not al.Model(model.terms).doubt
    assert not TRUTH.doubt
    assert "doubt" not in TRUTH.to_dict()
    assert replace(REJECTED, checked="").model.doubt == FIT.model.doubt == ""


def test_curves_still_show_what_a_rejected_model_predicts():
    curve = al.deviation(RECORD, "oadev", noise=REJECTED)
    assert np.isfinite(curve.interval()[0]).all()
    assert al.expected(REJECTED.model, "oadev", [1.0]) == pytest.approx(al.expected(FIT.model, "oadev", [1.0]))
