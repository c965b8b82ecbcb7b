"""The one search: its derivatives, its prices, its laws, and what it says of small records whose truth is known."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.signal import butter, iirpeak, lfilter
from tests import thinned
from tests.rows import rows
from tests.unit.identification.records import RATE, RC, B, K, N, covers, record_of, settled

import allanite as al
from allanite.identification.likelihood.filters import FILTERS, Filter
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search import moves as ways
from allanite.identification.search.components import CLAIMED, COMPONENTS, FACTORS, ODDS, Part, cost_of

from allanite.identification.search.fitting import (  # isort: skip
    SHAPE_ERRORS, admissible, factor_basis, fitted, likelihood_of, values_of, with_values
)  # fmt: skip
from allanite.identification.search.frame import frame_of
from allanite.identification.search.identify import moves_for
from allanite.identification.search.laws import _some_of_each_family, entries_of, law_of, weighted
from allanite.identification.search.refining import refined, resized
from allanite.identification.search.search import search
from allanite.identification.search.state import State, alike


def frame_from(y, symbols="QNBKR"):
    seen = spectrum(record_of(y), detrend="R" in symbols)
    return frame_of(seen, symbols, seen.read(None, ()))


def identified(y, **choices):
    return al.identify(record_of(y), **choices)


GM, PEAK, HIGH_PASS = (
    Part("noise", "GM", (400.0,)), Part("resonance", "flat", (0.6, 12.0)), Part("resonance", "high-pass", (1.7, 6.0)),
)  # fmt: skip
WIDE, ABOVE = Part("factor", "all", (0.0, 13.0, 0.3)), Part("factor", "above", (9.0, 13.0, 0.6))


@rows(
    "parts",
    [
        (GM,), (Part("noise", "GM", (40.0,)), Part("noise", "GM", (600.0,))), (Part("exponent", "", (1.3,)),),
        (Part("filter", "rc", (0.08,)),), (Part("filter", "bilinear 2", (0.2,)), Part("floor", "", ())),
        (PEAK, HIGH_PASS), (Part("resonance", "flat", (0.3, 150.0)),), (WIDE,),
        (GM, Part("filter", "rc", (0.1,)), PEAK, ABOVE),
    ],
    ids=lambda parts: "+".join(f"{p.name} {p.label}" for p in parts),
)  # fmt: skip
def test_slopes_are_those_of_the_expected_power(parts):
    """Up to what the sizes can do: a resonance is scaled by its highest bin, which its own size makes up for."""
    frame = frame_from(settled(behind=RC))
    f = fitted(frame, State().having(*parts))
    rng = np.random.default_rng(2)
    theta = f.theta.max() * 10.0 ** rng.uniform(-1, 0, f.theta.size) / f.likelihood.S.max(axis=0) * f.m.max()
    rank = factor_basis(frame, f.state).shape[1]
    v, x = 0.3 * rng.standard_normal(rank), values_of(f.state)
    f = replace(f, theta=theta, v=v, likelihood=likelihood_of(frame, f.state, v))
    m = f.likelihood.expectation(theta)

    def moved(i, h):
        y, w = x.copy(), v.copy()
        (y if i < x.size else w)[i if i < x.size else i - x.size] += h
        return likelihood_of(frame, with_values(f.state, y), w).expectation(theta)

    h = 1e-5
    central = np.array([(moved(i, h) - moved(i, -h)) / (2 * h) for i in range(x.size + rank)])
    sizes = f.likelihood.S / m[:, None]
    Q = np.linalg.qr(sizes / np.linalg.norm(sizes, axis=0))[0]
    ours, expected = ((rows_ / m) - (rows_ / m) @ Q @ Q.T for rows_ in (f.slopes, central))
    assert ours.shape == expected.shape
    for a, b, c in zip(ours, expected, central / m, strict=True):
        assert np.linalg.norm(a - b) < 0.01 * np.linalg.norm(b) + 1e-4 * np.linalg.norm(c)


def with_error(power, m, count, d):
    """What 2 L changes by where an error of variance d of ln m is integrated out in each bin."""
    r, dh = power / m, d * count / 2
    return float(np.sum(np.log1p(dh) - count * (r - 1 - np.log(r)) * dh / (1 + dh)))


@rows("parts", [(PEAK,), (GM, PEAK, HIGH_PASS), (Part("filter", "rc", (0.1,)), PEAK, ABOVE)])
def test_the_error_of_shapes_is_the_best_of_some_twice(parts):
    frame, state = frame_from(settled(behind=RC)), State().having(*parts)
    f, loud = fitted(frame, state), len(state.of("resonance"))
    part = likelihood_of(frame, state, f.v)
    theta, _ = part.minimise(f.free)
    for _ in range(2):
        power, m = (x[: part.power.size] for x in part.completed(theta)[:2])
        share = part.S[:, -loud:] @ theta[-loud:] / m
        d = min(((e * share) ** 2 for e in SHAPE_ERRORS), key=lambda d: with_error(power, m, part.count, d))
        trusted = part.trusted(1 / (1 + d * part.count / 2))
        theta, _ = trusted.minimise(f.free, theta)
    power, m = (x[: part.power.size] for x in part.completed(theta)[:2])
    J = factor_basis(frame, state) * (f.inside / f.m)[:, None]
    volume = np.linalg.slogdet(np.eye(f.v.size) + (J.T * trusted.count / 2) @ J)[1]
    assert f.theta == pytest.approx(theta, rel=1e-9, abs=1e-12 * theta.max())
    assert f.value == pytest.approx(2 * part.value(theta) + with_error(power, m, part.count, d) + volume, abs=1e-8)
    assert f.trusted.count == pytest.approx(trusted.count, rel=1e-12)
    for ours, literal in zip(f.of, trusted.completed(theta), strict=True):
        assert ours == pytest.approx(literal, rel=1e-9)


@rows("part", [PEAK, HIGH_PASS, Part("resonance", "flat", (0.3, 150.0))])
def test_a_resonance_is_white_noise_through_two_poles(part):
    frame, (omega, quality) = frame_from(settled()), part.shape
    at = np.arccos(frame.cosines(quality)[0])
    z, pole = np.exp(-1j * at), np.exp((-1 / (2 * quality) + 1j) * omega)
    power = np.sin(at) ** (2 * (part.label == "high-pass")) / abs((1 - pole * z) * (1 - pole.conj() * z)) ** 2
    power = power.mean(axis=1) / power.mean(axis=1).max()
    assert COMPONENTS["resonance"].power(frame, part) == pytest.approx(power, rel=1e-8)


def test_parts_of_a_state_stand_in_the_order_of_the_table_and_like_states_are_of_one_kind():
    every = [ABOVE, HIGH_PASS, PEAK, Part("filter", "rc", (0.1,)), GM, Part("step", "", (900.0,))]
    states = {State().having(*(every[i] for i in np.random.default_rng(k).permutation(len(every)))) for k in range(10)}
    (state,) = states
    assert [p.name for p in state] == ["noise", "filter", "resonance", "resonance", "factor", "step"]
    assert (state.lacking(GM).having(GM), state.lacking(GM, PEAK).of("resonance")) == (state, (HIGH_PASS,))
    other = state.lacking(PEAK).having(PEAK._replace(label="high-pass"))
    assert state.kind == state.lacking(PEAK).having(PEAK._replace(shape=(0.605, 12.1))).kind != other.kind
    assert state.form == other.form
    assert not alike(state, state.lacking(GM))


@rows("parts, may", [
    ((Part("floor", "", ()),), False), ((Part("filter", "rc", (0.02,)), Part("floor", "", ())), False),
    ((Part("filter", "rc", (0.2,)), Part("floor", "", ())), True),
    ((Part("filter", "rc", (0.2,)), Part("filter", "rc", (0.1,))), False), ((GM, GM, GM), False),
])  # fmt: skip
def test_what_may_stand_together(parts, may):
    assert State().having(*parts).admitted(frame_from(settled())) is may


def test_a_price_is_what_noise_alone_gains_at_its_rate():
    """As the page of components says."""
    said = {
        "term": 4.0, "noise": 9.2, "filter": 10.8, "floor": 13.5, "resonance": 18.5, "step": 20.1, "warm-up": 15.5,
        "sinusoid": 30.0,
    }  # fmt: skip
    assert {name: COMPONENTS[name].price(2**16) for name in said} == pytest.approx(said, abs=0.1)
    assert pytest.approx(1 / (1 + math.exp(-1))) == CLAIMED


def test_a_state_costs_what_its_parts_and_terms_do():
    frame = frame_from(settled())
    parts = sum(COMPONENTS[name].cost(frame.size) for name in ("noise", "resonance")) + FACTORS["all"] - ODDS
    assert State().having(GM, PEAK, WIDE).cost(frame) == pytest.approx(parts)
    f = fitted(frame, State())
    assert f.score - f.value == pytest.approx(4 * 2.0 + 2.0, abs=0.1)  # angle noise costs two more
    behind = fitted(frame, State().having(Part("filter", "rc", (0.2,))))
    assert behind.score - behind.value - behind.state.cost(frame) == pytest.approx(4 * 2.0 + 4.0, abs=0.1)
    assert cost_of(Part("noise", "GM2", (9.0, 0.1)), frame) > cost_of(GM, frame) + 5


def humped(n=2**13, seed=3):
    y, rng = settled(n=n, seed=seed), np.random.default_rng(seed + 1000)
    return y + 4 * y.std() * lfilter(*iirpeak(20, 20, RATE), rng.standard_normal(n))


@rows("record", [
    settled(seed=4, behind=RC), humped(), settled(N + K, seed=5) + 0.02 * np.exp(-np.arange(2**13) / 900.0),
], ids=["rc", "hump", "warm-up"])  # fmt: skip
def test_the_order_of_the_moves_decides_nothing(record):
    kept = []
    for k in range(3):
        order = [ways.MOVES[i] for i in np.random.default_rng(k).permutation(len(ways.MOVES))]
        result = search(frame_from(record), moves=order)
        kept.append({f.state.family: f.score for f in reversed(result.kept)})
    for other in kept[1:]:
        assert (set(other), other) == (set(kept[0]), pytest.approx(kept[0], abs=0.05))


def test_what_is_looked_for_follows_from_what_is_asked():
    def named(band, *, rival=True):
        return {move.__name__ for move in moves_for(band, rival=rival)}

    every = {move.__name__ for move in ways.MOVES}
    assert (named("auto"), named((0.0, 10.0))) == (every, every - {"filters", "floors"})
    assert named("all") == every - {"filters", "floors", "resonances"}
    assert named("auto", rival=False) == every - {"markov", "exponents"}


def test_a_refined_fit_is_the_least_nearby():
    frame = frame_from(settled(al.Model((N, al.GM(0.02, "deg/s", time_constant=1.0))), 2**14))
    best = refined(fitted(frame, State().having(Part("noise", "GM", (60.0,)))), settled=1e-4)
    assert best.state.parts[0].shape[0] == pytest.approx(100, rel=0.4)
    for factor in (0.9, 0.97, 1.03, 1.1):
        near = fitted(frame, with_values(best.state, values_of(best.state) + math.log(factor)))
        assert near.value > best.value - 1e-3


def test_weights_and_laws_are_those_of_all_that_is_kept():
    entries = entries_of(search(frame_from(settled(N + B + K, 2**14, 6))))
    weights = [e.weight for e in entries]
    assert sum(weights) == pytest.approx(1)
    assert weights == sorted(weights, reverse=True)
    for which in range(4):
        law = law_of(entries, which)
        assert (np.diff([law.quantile(float(p)) for p in np.linspace(0.001, 0.999, 99)]) >= 0).all()
        assert law.weight == pytest.approx(sum(e.weight for e in entries if e.f.free[which]))


def every_subset(result):
    """The models of the average, every subset of the powers beside each state being fitted."""
    models = {}
    for f in _some_of_each_family(result.kept):
        models[f.state.kind, f.free.tobytes()] = f
        full = resized(f, np.ones(f.theta.size, dtype=bool))
        for bits in product((False, True), repeat=len(result.frame.powers)):
            may = admissible(f.frame, f.state, np.array([*bits, *full.free[len(bits) :]]), f.theta.size)
            if may.any() and (f.state.kind, may.tobytes()) not in models:
                models[f.state.kind, may.tobytes()] = resized(full, may)
    return weighted([f for f in models.values() if math.isfinite(f.score)])


def test_subsets_that_are_not_fitted_would_weigh_nothing():
    for seed, behind in ((6, None), (7, RC)):
        result = search(frame_from(settled(N + B + K, 2**13, seed, behind)))
        ours, every = (
            {(e.f.state.kind, e.f.free.tobytes()): e.weight for e in entries}
            for entries in (entries_of(result), every_subset(result))
        )
        assert ours == pytest.approx(every, rel=1e-12)


def test_look_alikes_weigh_as_the_best_of_them():
    frame = frame_from(settled(seed=7, behind=RC))
    free = np.array([False, True, True, False])
    states = (State().having(Part("filter", row, (1 / 12,))) for row in ("rc", "bilinear 1", "averaged rc"))
    filtered = [refined(fitted(frame, state, free)) for state in states]
    bare = fitted(frame, State(), free)
    behind_one = [e for e in weighted([*filtered, bare]) if e.f.state.parts]
    best = min(f.score for f in filtered)
    assert sum(e.weight for e in behind_one) == pytest.approx(1 / (1 + math.exp((best - bare.score) / 2)), rel=1e-3)
    assert len({e.f.state.family for e in behind_one}) == 1


NOTCHED = butter(4, 0.24)


def fourth_order(f, cutoff):
    """A digital Butterworth filter of the 4th order: in no row of the table."""
    warped = np.tan(np.pi * np.minimum(np.asarray(f, dtype=float), 0.499999)) / math.tan(math.pi * min(cutoff, 0.45))
    return 1 / (1 + warped**8)


def test_a_new_row_of_the_filters_is_taken_by_its_row_alone(monkeypatch):
    row = Filter("4th-order low-pass", fourth_order, 0.45 * 2.0 ** -np.arange(6.0))
    monkeypatch.setitem(FILTERS, "fourth order of a test", row)
    fit = identified(settled(N + B, 2**14, 2, NOTCHED))
    assert fit.scope.filter.row == "fourth order of a test"
    assert fit.scope.filter.cutoff == pytest.approx(12.0, rel=0.02)
    assert "4th-order low-pass" in fit.scope.sentences[0]
    assert covers(fit, N)
    assert fit["N"].value == pytest.approx(N.value, rel=0.05)


@pytest.mark.slow("seconds of searches")
@rows("seed", thinned(range(2), 1))
def test_an_unknown_filter_keeps_the_plateau_or_is_refused(seed):
    """Without its row what it takes away is power that nothing describes: N is the level below it, or not explained."""
    fit = identified(settled(N + B, 2**14, seed, NOTCHED))
    plateau = fit["N"].value == pytest.approx(N.value, rel=0.15) and covers(fit, N, 0.99)
    assert plateau or fit.validity == "unexplained"


def test_a_band_and_masks_are_those_of_the_user():
    quiet, t = settled(N + B, 2**13, 8), np.arange(2**13) / RATE
    loud = quiet + 20 * quiet.std() * np.sin(2 * np.pi * 30.2 * t)
    for choices in ({"band": (0.0, 20.0)}, {"masks": [(25.0, 35.0)]}, {"band": (0.0, 45.0), "masks": [(25.0, 35.0)]}):
        fit = identified(loud, lines=False, **choices)
        assert fit.scope.choice == ("asked" if "band" in choices else "auto")
        assert fit.scope.masks == tuple(choices.get("masks", ()))
        assert fit.scope.band[1] == choices.get("band", (0.0, 50.0))[1]
        assert covers(fit, N)
        assert not [c for c in fit.components if c.name == "resonance" and c.claimed]
    assert identified(quiet).scope.masks == ()


def test_a_resonance_is_a_component_with_its_place():
    fit = identified(humped(2**14))
    (peak,) = (c for c in fit.components if c.name == "resonance" and c.claimed)
    assert peak.low < 20 < peak.high
    assert peak.weight > 0.99
    assert peak.words.startswith("vibration at ")
    assert covers(fit, N)
    ((low, high),) = fit.scope.disturbed
    assert 15 < low < 20 < high < 25
    assert (fit.validity, fit.scope.masks) == ("explained", ())
    assert "vibration at" in " ".join(fit.supposed)
    assert fit.scope.holds(np.array([1 / 20, 10.0])).tolist() == [False, True]


def test_flicker_is_no_power_that_nothing_describes():
    """A factor that stands at the lowest octaves alone could take the place of any slow noise."""
    fits = [identified(settled(N + al.B(0.006, "deg/s"), 2**14, seed)) for seed in range(4)]
    assert all(fit["B"].claimed for fit in fits)
    assert not any(c.claimed for fit in fits for c in fit.components if c.name == "factor")


@rows("seed", range(4))
def test_clean_records_hold_nothing_beside_the_terms(seed):
    fit = identified(settled(N + B + K, 2**13, seed + 20))
    assert [c for c in fit.components if c.claimed] == []
    assert fit.scope.whole
    assert covers(fit, N)


@rows("end", [0, -1])
def test_a_short_record_whose_first_or_last_sample_stands_out_is_searched(end):
    y = np.random.default_rng(2).standard_normal(200)
    y[end] += 4.5
    assert identified(y)["N"].value is not None
