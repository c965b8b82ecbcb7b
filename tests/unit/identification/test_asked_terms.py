"""Terms that are looked for when they are asked for: found, within their limits, and not where they are absent."""

import numpy as np
import pytest

import allanite as al

RATE, SIZE = 20.0, 2**14
QN = al.Q(0.3, "arcsec") + al.N(0.05, "deg/sqrt(h)")
NB = al.N(0.05, "deg/sqrt(h)") + al.B(1.0, "deg/h")
CELLS = {
    "F": (QN, al.F(1.0, "arcsec"), "QFN"),
    "GMA": (QN, al.GMA(3.0, "arcsec", time_constant=2.0), "Q,N,GMA"),
    "GM2": (NB, al.GM2(20.0, "deg/h", frequency=0.3, damping=0.15), "N,B,GM2"),
    "W": (NB, al.W(20.0, "deg/h", time_constant=80.0), "N,B,K,W"),
}


def identified(model, terms, seed):
    return al.identify(al.simulate(model, SIZE, RATE, rng=np.random.default_rng(seed)), terms=terms)


@pytest.mark.parametrize("symbol", CELLS)
def test_it_is_found_within_its_limits(symbol):
    """Limits of 99.9 %: one failure in 300 runs of all."""
    rest, extra, terms = CELLS[symbol]
    fit = identified(rest + extra, terms, 5)
    estimate = fit[symbol]
    assert estimate.claimed
    assert fit.goodness.explained
    low, high = estimate.interval(0.999)
    assert low < extra.value < high
    for truth, (low, high) in zip(extra.shape, estimate.shape_limits(0.999) if extra.shape else (), strict=True):
        assert low < truth < high
    assert fit.model[symbol].shape == estimate.shape
    assert al.Fit.from_dict(fit.to_dict())[symbol].value == estimate.value


@pytest.mark.parametrize("symbol", CELLS)
def test_it_is_absent_where_it_is_not(symbol):
    rest, _, terms = CELLS[symbol]
    estimate = identified(rest, terms, 6)[symbol]
    assert estimate.status == "absent"
    assert symbol == "W" or estimate.upper > 0


def test_the_automatic_search_does_not_look_for_them():
    fit = identified(QN + CELLS["F"][1], "auto", 5)
    assert {e.symbol for e in fit} <= {*"QNBKR", "GM"}


def test_two_shapes_at_a_time_are_refused():
    with pytest.raises(al.UsageError, match="only one noise with a time constant or a frequency"):
        identified(NB, "N,GM,GM2", 1)


def test_the_model_takes_a_warm_up_out_of_the_residuals():
    from allanite.identification.checks.whitening import whitened

    rest, extra, terms = CELLS["W"]
    record = al.simulate(rest + extra, SIZE, RATE, rng=np.random.default_rng(5))
    start = [abs(whitened(record, model)[:500].mean()) for model in (identified(rest + extra, terms, 5), rest)]
    assert start[0] < 5 / np.sqrt(500) < start[1]


def test_curves_do_not_take_what_has_a_shape():
    record = al.simulate(NB, 2000, RATE, rng=np.random.default_rng(1))
    with pytest.raises(al.UsageError, match="has shape parameters as well: use method 'whittle'"):
        al.identify(record, "gls", terms="N,GMA")
