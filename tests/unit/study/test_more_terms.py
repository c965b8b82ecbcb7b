"""A record that the automatic terms do not describe names the terms that do, and asking for them helps."""

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.interpretation.sentences import meaning
from allanite.study.noise import noise_of

pytestmark = pytest.mark.slow("searches of terms with shapes")

RATE, SIZE = 40.0, 72_000
HUMPS = {
    "weakly damped": ("N 0.3 arcsec*sqrt(s), GM2 1.2 arcsec 0.3 Hz 0.05, R 0.5 arcsec/s", "N,R,GM2", 62),
    "loud": ("N 0.3 arcsec*sqrt(s), GM2 4 arcsec 0.3 Hz 0.02, R 0.5 arcsec/s", "N,R,GM2", 60),
    "critically damped": ("N 0.3 arcsec*sqrt(s), GM2 1.2 arcsec 0.3 Hz 1, R 0.5 arcsec/s", "N,R,GM2", 20),
}


def simulated(name):
    text, _, seed = HUMPS[name]
    return al.simulate(al.Model(text), SIZE, RATE, rng=np.random.default_rng(seed))


def channel_of(record, **choices):
    return al.analyze(record, al.Recipe(**choices)).channels[0]


@rows("name", HUMPS)
def test_what_is_named_describes_the_record(name):
    text, terms, _ = HUMPS[name]
    record = simulated(name)
    found = channel_of(record).fit.findings[0]
    assert (found.name, found.remedy) == ("terms", f"ask for them (terms={terms!r})")
    channel = channel_of(record, terms=terms)
    assert (channel.noise.validity, channel.warnings) == ("explained", ())
    meant = meaning(channel.fit, rate=RATE, length=SIZE / RATE, device="stabilizer")
    shaped = [t for t in al.Model(text) if t.shape]
    for term, estimate in zip(shaped, (e for e in channel.fit if e.shape), strict=True):
        assert np.allclose((estimate.value, *estimate.shape), (term.value, *term.shape), rtol=0.5)
        assert estimate.symbol in meant.causes
    assert sum("was identified: look for a" in said for said in meant.sentences) == len(shaped)


def test_of_a_body_that_moved_no_more_terms_are_named():
    assert "terms" not in {f.name for f in noise_of(simulated("loud"), al.Recipe(), moved=True).fit.findings}


def test_two_relaxation_processes_are_told_apart_without_being_named():
    model = al.Model("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s, GM 1 arcsec 20 s")
    fit = channel_of(al.simulate(model, SIZE, RATE, rng=np.random.default_rng(20))).fit
    assert fit.validity == "explained"
    for symbol, tau in (("GM", 2.0), ("GML", 20.0)):
        ((low, high),) = fit[symbol].shape_limits(0.95)
        assert low < tau < high


def test_nothing_is_named_where_nothing_is_missing():
    record = al.simulate(al.Model("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s"), SIZE, RATE, rng=np.random.default_rng(1))
    assert channel_of(record).fit.findings == ()


def test_an_oscillation_that_is_modeled_is_no_motion():
    """The curve falls more steeply beyond the hump than before it, which five terms never do."""
    model = al.Model("N 0.3 arcsec*sqrt(s), GM2 1.2 arcsec 0.3 Hz 0.15")
    channel = channel_of(al.simulate(model, SIZE, RATE, rng=np.random.default_rng(4)), terms="N,GM2")
    assert "slope" in channel.quality.names
    assert channel.fit["GM2"].claimed
    assert channel.warnings == ()
