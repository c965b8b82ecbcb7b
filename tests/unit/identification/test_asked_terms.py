"""Terms that are looked for when they are asked for: found, within their limits, and not where they are absent."""

import numpy as np
import pytest
from tests.rows import refused, rows
from tests.unit.identification.records import covers

import allanite as al
from allanite.identification.checks.whitening import whitened
from allanite.identification.methods import symbols_of

RATE, SIZE = 20.0, 2**14
QN = al.Q(0.3, "arcsec") + al.N(0.05, "deg/sqrt(h)")
NB = al.N(0.05, "deg/sqrt(h)") + al.B(1.0, "deg/h")
PROCESS = al.N(0.05, "deg/sqrt(h)") + al.GM(20.0, "deg/h", time_constant=1.0)
CELLS = {
    "F": (QN, al.F(1.0, "arcsec"), "QFN"),
    "GMA": (QN, al.GMA(3.0, "arcsec", time_constant=2.0), "Q,N,GMA"),
    "GM2": (NB, al.GM2(20.0, "deg/h", frequency=0.3, damping=0.15), "N,B,GM2"),
    "GML": (PROCESS, al.GML(20.0, "deg/h", time_constant=30.0), "N,GM,GM"),
    "GM2 beside GM": (PROCESS, al.GM2(20.0, "deg/h", frequency=0.05, damping=0.15), "N,GM,GM2"),
    "W": (NB, al.W(20.0, "deg/h", time_constant=80.0), "N,B,K,W"),
}


def identified(model, terms, seed):
    return al.identify(al.simulate(model, SIZE, RATE, rng=np.random.default_rng(seed)), terms=terms)


@pytest.mark.slow("seconds of analyses")
@rows("cell", CELLS)
def test_it_is_found_within_its_limits(cell):
    """Limits of 99.9 %: one failure in 200 runs of all."""
    rest, extra, terms = CELLS[cell]
    fit = identified(rest + extra, terms, 5)
    assert fit.goodness.explained
    for term in (extra, *(t for t in rest if t.shape)):
        estimate = fit[term.symbol]
        assert estimate.claimed
        assert covers(fit, term, 0.999)
        for truth, (low, high) in zip(term.shape, estimate.shape_limits(0.999) if term.shape else (), strict=True):
            assert low < truth < high
        assert fit.model[term.symbol].shape == estimate.shape
        assert al.Fit.from_dict(fit.to_dict())[term.symbol].value == estimate.value


@pytest.mark.slow("seconds of analyses")
@rows("cell", CELLS)
def test_it_is_absent_where_it_is_not(cell):
    rest, extra, terms = CELLS[cell]
    fit = identified(rest, terms, 6)
    estimate = fit[extra.symbol]
    assert estimate.status == "absent"
    assert rest is PROCESS or extra.symbol == "W" or estimate.upper > 0
    assert all(fit[term.symbol].claimed for term in rest if term.shape)


@rows("terms", ["N,GM,GM", "GM,N,GML", "NGMGM", ["N", "GM", "GM"]])
def test_a_second_process_is_the_slow_one(terms):
    assert sorted(symbols_of(terms)) == ["GM", "GML", "N"]


def test_the_automatic_search_does_not_look_for_them():
    fit = identified(QN + CELLS["F"][1], "auto", 5)
    assert {e.symbol for e in fit} <= {*"QNBKR", "GM"}


def test_a_third_process_or_shape_is_refused():
    refused(al.UsageError, "must name each symbol once, GM twice at most", lambda: symbols_of("N,GM,GM,GM"))
    words = "at most two noises with a time constant or a frequency .* GM, GML, GM2"
    refused(al.UsageError, words, lambda: identified(NB, "N,GM,GM,GM2", 1))


def test_the_model_takes_a_warm_up_out_of_the_residuals():
    rest, extra, terms = CELLS["W"]
    record = al.simulate(rest + extra, SIZE, RATE, rng=np.random.default_rng(5))
    start = [abs(whitened(record, model)[:500].mean()) for model in (identified(rest + extra, terms, 5), rest)]
    assert start[0] < 5 / np.sqrt(500) < start[1]
