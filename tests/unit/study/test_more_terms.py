"""A record that the automatic terms do not describe names the terms that do, and asking for them helps."""

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.interpretation.sentences import meaning
from allanite.study.noise import noise_of

pytestmark = pytest.mark.slow("searches of terms with shapes")

RATE, SIZE = 40.0, 72_000
WEAK, LOUD, CRITICAL = (
    f"N 0.3 arcsec*sqrt(s), GM2 {hump}, R 0.5 arcsec/s" for hump in
    ("1.2 arcsec 0.3 Hz 0.05", "4 arcsec 0.3 Hz 0.02", "1.2 arcsec 0.3 Hz 1")
)  # fmt: skip


def simulated(text, seed):
    return al.simulate(al.Model(text), SIZE, RATE, rng=seed)


def channel_of(record, **choices):
    return al.analyze(record, al.Recipe(**choices)).channels[0]


@rows("text, seed", [(WEAK, 62), (LOUD, 60), (CRITICAL, 20)])
def test_what_is_named_describes_the_record(text, seed):
    record = simulated(text, seed)
    finding = channel_of(record).fit.findings[0]
    assert (finding.name, finding.remedy) == ("terms", "ask for them (terms='N,R,GM2')")
    channel = channel_of(record, terms="N,R,GM2")
    assert (channel.noise.validity, channel.warnings) == ("explained", ())
    meant = meaning(channel.fit, rate=RATE, length=SIZE / RATE, device="stabilizer")
    shaped = [t for t in al.Model(text) if t.shape]
    for term, estimate in zip(shaped, (e for e in channel.fit if e.shape), strict=True):
        assert np.allclose((estimate.value, *estimate.shape), (term.value, *term.shape), rtol=0.5)
        assert estimate.symbol in meant.causes
    assert sum("was identified: look for a" in said for said in meant.sentences) == len(shaped)


def test_of_a_body_that_moved_and_where_nothing_is_missing_no_more_terms_are_named():
    assert "terms" not in {f.name for f in noise_of(simulated(LOUD, 60), al.Recipe(), moved=True).fit.findings}
    assert channel_of(simulated("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s", 1)).fit.findings == ()


def test_two_relaxation_processes_are_told_apart_without_being_named():
    fit = channel_of(simulated("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s, GM 1 arcsec 20 s", 20)).fit
    assert fit.validity == "explained"
    for symbol, tau in (("GM", 2.0), ("GML", 20.0)):
        ((low, high),) = fit[symbol].shape_limits(0.95)
        assert low < tau < high


def test_an_oscillation_that_is_modeled_is_no_motion():
    """The curve falls more steeply beyond the hump than before it, which five terms never do."""
    channel = channel_of(simulated("N 0.3 arcsec*sqrt(s), GM2 1.2 arcsec 0.3 Hz 0.15", 4), terms="N,GM2")
    assert "slope" in channel.quality.names
    assert channel.fit["GM2"].claimed
    assert channel.warnings == ()
