"""The law of a coefficient against the same by brute force, and what it says where nothing is known."""

import itertools

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search.frame import frame_of
from allanite.identification.search.laws import entries_of, law_of
from allanite.identification.search.search import search

MODEL = al.N(1, "deg/sqrt(h)") + al.B(6, "deg/h") + al.K(30, "deg/h/sqrt(h)")


def entries(record, symbols):
    """The models of the terms alone, with their weights."""
    seen = spectrum(record, detrend="R" in symbols)
    return entries_of(search(frame_of(seen, symbols, seen.read(None, ())), moves=(), unexplained=False))


@pytest.fixture(scope="module")
def models():
    return entries(al.simulate(MODEL, 3000, 1.0, rng=np.random.default_rng(1)), "QNBKR")


def by_force(models, which, root):
    """Cumulative probability at the roots: every subset that has the term, minimised at each of them."""
    density = np.zeros(root.size)
    for entry in models:
        if entry.f.free[which]:
            part, free = entry.f.likelihood, entry.f.free
            least = np.array([part.minimise(free, None, (which, c * c))[1] for c in root])
            own = np.exp(least.min() - least)
            density += entry.weight * own / own.sum()
    below = np.concatenate(([0.0], np.cumsum(density[1:] + density[:-1])))
    return below / below[-1]


@rows("which", range(4))
def test_it_is_that_of_all_subsets_on_a_fine_grid(models, which):
    ours = law_of(models, which)
    root = np.linspace(ours.root[0], ours.root[-1], 301)
    dense = by_force(models, which, root)
    spread = ours.quantile(0.84) - ours.quantile(0.16)
    for p in (0.025, 0.16, 0.5, 0.84, 0.975):
        assert ours.quantile(p) == pytest.approx(float(np.interp(p, dense, root)), abs=0.04 * spread)


def test_its_spread_is_that_of_the_bound():
    ours = law_of(entries(al.simulate(record_model(), 4096, 1.0, rng=np.random.default_rng(2)), "N"), 0)
    low, high = ours.limits(0.95)
    assert (high - low) / 3.92 / ours.quantile(0.5) == pytest.approx(
        float(al.bound(record_model(), 4096, 1.0)["N"]), rel=0.1
    )


def record_model():
    return al.Model((al.N(1, "deg/sqrt(h)"),))


def test_what_is_absent_has_a_median_and_claims_nothing_and_what_cannot_be_seen_has_none():
    absent = al.identify(al.simulate(MODEL, 3000, 1.0, rng=np.random.default_rng(1)))["Q"]
    low, high = absent.interval(0.95)
    assert low == 0
    assert 0 < absent.median < high
    record = al.simulate(MODEL, 500, 1.0, rng=np.random.default_rng(3))
    e = al.identify(record)["B"]
    assert e.value is None
    assert not e.claimed
    assert 0 < e.median < e.interval(0.95)[1]
    record = al.simulate(al.sensor("mems"), 20_000, 100.0, rng=np.random.default_rng(4))
    fit = al.identify(record, band=(0, 5))
    assert (fit["Q"].status, fit["Q"].median) == ("not observable", None)


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
def test_estimates_are_correlated_as_the_fit_says():
    """Against the scatter over simulated records; the standard error of a correlation of 200 is 0.07."""
    model = al.N(1, "deg/sqrt(h)") + al.B(20, "deg/h")
    fits = [
        al.identify(al.simulate(model, 4096, 1.0, rng=np.random.default_rng((7, i))), terms="NB") for i in range(200)
    ]
    sizes = [[fit["N"].median, fit["B"].median] for fit in fits if fit["B"].status != "not valid"]
    assert len(sizes) > 190
    found = np.corrcoef(sizes, rowvar=False)[0, 1]
    said = np.mean([fit.correlation[0, 1] for fit in fits])
    assert said == pytest.approx(found, abs=0.2)
    assert said < -0.3
    assert np.isnan(al.identify(al.simulate(model, 4096, 1.0, rng=np.random.default_rng(8))).correlation).any()


def test_an_interval_holds_its_value():
    # here a third term is weak: some of the models that are possible have it, and N differs between them
    model = al.N(0.1, "deg/sqrt(h)") + al.B(1, "deg/h")
    fit = al.identify(al.simulate(model, size=2_000_000, rate=100.0, rng=np.random.default_rng(1)))
    claimed = [estimate for estimate in fit if estimate.value is not None]
    assert len(claimed) > 1
    for estimate, level in itertools.product(claimed, (0.3, 0.68, 0.95)):
        low, high = estimate.interval(level)
        assert low <= estimate.value <= high
