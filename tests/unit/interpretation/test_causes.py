"""What coefficients mean: tables that are complete and cited, and sentences that are right on fits made for them."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.core.fit import Goodness
from allanite.core.readings import Reading, Readings
from allanite.core.units import convert, signal_named
from allanite.core.validity import LowPass, Scope
from allanite.interpretation.devices import GRADES, REFERENCES, bounds_of, grade_of
from allanite.interpretation.sentences import least, meaning, sentences, spans
from allanite.reporting import first_screen, page

GYRO = signal_named("gyro")


def estimate(symbol, value=None, unit=None, *, upper=None, shape=()):
    """A term that was found, or one that was not, below `upper`."""
    si = GYRO.si[al.terms.TERMS[symbol].power]
    size, most = (None if number is None else convert(number, unit, si) for number in (value, upper))
    status = "absent" if value is None else "identified"
    return al.Estimate(symbol, GYRO, size, None, status, most, "whittle", shape=shape)


def fit(*estimates, p=0.5, **more):
    model = al.Model(tuple(al.Term(e.symbol, abs(e.value), GYRO, e.shape) for e in estimates if e.value is not None))
    edges = np.array([0.1, 1.0])
    return al.Fit(estimates, "whittle", GYRO, model, goodness=Goodness(edges, edges[:1], edges[:1], p), **more)


def read(minimum, tau, *, inside=True):
    size = convert(minimum, "deg/h", "rad/s")
    point = Reading(tau, size, lambda level: (0.0, 1.5 * size))
    return Readings(GYRO, point, None, point, inside, (), ())


N = estimate("N", 0.1, "deg/sqrt(h)")
K = estimate("K", 20.0, "deg/h/sqrt(h)")
R = estimate("R", -3000.0, "deg/h^2")


def said(*estimates, readings=None, length=3600.0, **more):
    return " ".join(sentences(fit(*estimates, **more), readings, rate=100.0, length=length))


@rows("name", al.interpretation.DEVICES)
def test_every_term_of_every_device_has_its_name_sources_remedies_and_reference(name):
    device = al.interpretation.DEVICES[name]
    assert device.name == name
    assert set(device.terms) >= set("QNBKR")
    assert set(device.signals) - {"angle"} <= {"gyro", "accelerometer", "dimensionless"}
    for cause in device.terms.values():
        assert len(cause.name) > 5
        assert cause.sources
        assert cause.remedies
        assert all(len(text) > 10 for text in (*cause.sources, *cause.remedies))
        for part in re.sub(r"\(.*?\)", "", cause.reference).split("; "):
            assert any(part.startswith(key) for key in REFERENCES), part


def test_all_references_are_cited():
    text = " ".join(cause.reference for device in al.interpretation.DEVICES.values() for cause in device.terms.values())
    assert [key for key in REFERENCES if key not in text] == []


@rows("name", ["fgo", "FOG", ""])
def test_an_unknown_device_is_refused_before_anything_is_read(name):
    done = run("analyze", "missing.csv", "--device", name)
    ends(done, 2, f"unknown device {name!r}", "nown devices: stabilizer, mscsg, rlg, fog, mems, accelerometer")


def test_grades_follow_each_other():
    names, bounds = [*GRADES], [*GRADES.values()]
    assert bounds == sorted(bounds)
    assert math.isinf(bounds[-1])
    for i, below in enumerate(bounds[:-1]):
        assert [grade_of(below * 0.999), grade_of(below)] == names[i : i + 2]
        assert f"{below:g}" in bounds_of(names[i])
    assert grade_of(1.2) == "Tactical grade"


def test_crossings_and_humps():
    n, k, r = (convert(e.value, e.unit, e.sheet_unit) for e in (N, K, R))
    hours = {s.symbol: (s.start / 3600, s.end / 3600) for s in spans([N, K], 0.01, 1800.0)}
    assert hours["N"][1] == hours["K"][0] == pytest.approx(math.sqrt(3) * n / k)
    hours = {s.symbol: (s.start / 3600, s.end / 3600) for s in spans([N, R], 0.01, 1800.0)}
    assert hours["N"][1] == pytest.approx((math.sqrt(2) * n / abs(r)) ** (2 / 3))
    b = estimate("B", 2.0, "deg/h")
    slow = estimate("K", 10.0, "deg/h/sqrt(h)"), estimate("R", 100.0, "deg/h^2")
    found = spans([estimate("Q", 1.0, "arcsec"), N, b, *slow], 1e-4, 1e5)
    assert [span.symbol for span in found] == ["Q", "N", "B", "R"]  # K is nowhere the largest
    assert found[1].end / 3600 == pytest.approx(n**2 / (2 * math.log(2) / math.pi * 2.0**2))
    # a hump is held against the lines
    hump = estimate("GM", 60.0, "deg/h", shape=(20.0,))
    found = spans([N, hump], 0.01, 1800.0)
    assert [span.symbol for span in found] == ["N", "GM"]
    tau = found[0].end
    sizes = [float(al.expected(al.Term(e.symbol, e.value, GYRO, e.shape), "adev", [tau])[0]) for e in (N, hump)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.01)
    # a curve that falls or rises to its end has no minimum
    white, walk = (al.identify(al.simulate(al.Model(text), 4000, 10.0, rng=np.random.default_rng(1))) for text in
                   ("N 0.1 deg/sqrt(h)", "K 900 deg/h/sqrt(h)"))  # fmt: skip
    assert least(list(white), 0.1, 100.0) is None
    assert least(list(walk), 1.0, 100.0) is None


def test_sentences():
    text = said(N, K)
    at = 3600 * math.sqrt(3) * 0.1 / 20
    assert f"White noise (angle random walk) dominates up to {at:.3g} s" in text
    assert f"Drift (rate random walk) dominates from {at:.3g} s on." in text
    alone = said(N)
    assert "dominates at all averaging times: averaging reduces the error" in alone
    assert "rift" not in alone
    between = said(N, estimate("Q", 1.0, "arcsec"))
    assert "dominates from 0.0833 s up to half the length" in between
    assert "White" not in said(K)
    assert "Drift (rate random walk) dominates at all averaging times." in said(K)
    # systematic and random drift
    at = 3600 * 2 * 20.0**2 / (3 * 3000.0**2)  # of R^2 tau^2 / 2 = K^2 tau / 3
    both = said(N, K, R)
    assert "a systematic part, R, which changes the output by 3000 deg/h over the record" in both
    assert "a random part, K, of 20 deg/h (1 sigma)" in both
    assert f"R is larger than K beyond {at:.3g} s" in both
    systematic = said(N, R, estimate("K", upper=7.0, unit="deg/h/sqrt(h)"))
    assert "The drift is systematic: R changes the output by 3000 deg/h over the record; K was not " in systematic
    assert "its size is below 7 deg/h/sqrt(h)." in systematic
    assert "The drift is random: K changes the output by 10 deg/h (1 sigma)" in said(N, K, length=900.0)
    # the minimum stands beside flicker
    text = said(N, estimate("B", 1.5, "deg/h"), readings=read(1.5, 50.0))
    assert "deviation is 1.5 (0.0 .. 2.2) deg/h at 50 s; divided by 0.664 it would be a B of 2.26 deg/h; the" in text
    absent = estimate("B", upper=0.8, unit="deg/h")
    level = math.sqrt(2 * 0.1 * 20 / math.sqrt(3))
    text = said(N, K, absent, readings=read(1.5, 31.2))
    assert "B is below 0.8 deg/h" in text
    assert f"the other terms alone make a minimum of {level:.3g} deg/h at 31.2 s." in text
    assert "minimum of the Allan" not in said(N, absent, readings=read(1.5, 1800.0, inside=False))
    # time constants
    process = estimate("GM", 60.0, "deg/h", shape=(2.0,))
    looked = "A Gauss-Markov process with a time constant of 2 s was identified: look for a control loop"
    assert looked in said(N, process)
    low = LowPass("first order", "1st-order low-pass", 20.0, 19.0, 21.0, 100.0)
    scope = Scope("auto", (0.0, 50.0), (), low, 0.0, 0.0, np.array([1.0, 50.0]), np.ones(2))
    text = said(N, scope=scope)
    assert "A low-pass filter of 20 Hz was identified (time constant 7.96 ms if it is of first order)" in text
    # the grade of a gyro
    text = said(N, readings=read(1.5, 50.0))
    assert "in-run bias stability, 1.5 (0.0 .. 2.2) deg/h at 50 s (0.01 to 5 deg/h); grades are conventions" in text
    assert "by its angle random walk" not in text
    better = said(N, readings=read(4.0, 1800.0, inside=False))  # the upper limit counts
    assert "Industrial grade or better by its in-run bias stability, 4.0 (0.0 .. 6.0) deg/h at 1800 s, still" in better
    # what is not valid says nothing
    assert said(N, K, p=1e-6) == ""
    assert "Drift" not in said(N, replace(K, status="not valid"))
    curve = al.identify(al.simulate(al.N(0.1, "deg/sqrt(h)"), 3000, 10.0, rng=np.random.default_rng(1)), method="nnls")
    assert sentences(curve, rate=10.0, length=300.0) == ()  # a method without a test of its model


def test_a_device_names_the_causes_of_what_was_found():
    found = meaning(fit(N, estimate("K", upper=7.0, unit="deg/h/sqrt(h)")), rate=100.0, length=3600.0, device="mems")
    assert list(found.causes) == ["N"]
    other = meaning(fit(N), rate=100.0, length=3600.0, device="accelerometer")
    assert other.causes == {}
    assert "about accelerometer signals, not about this gyro" in other.note
    assert meaning(fit(N, p=1e-6), rate=100.0, length=3600.0, device="mems").causes == {}


@pytest.mark.slow("takes more than half a second")
def test_a_loop_has_its_time_constant_and_is_drawn_without_the_ramp():
    model = al.Model("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s, R 0.5 arcsec/s")
    study = al.analyze(al.simulate(model, 24_000, 40.0, rng=np.random.default_rng(2), name="azimuth"))
    row = r"(?m)^T +time constant +s +[12]\.\d+ \([12]\.\d+ \.\. [23]\.\d+\)$"
    assert re.search(row, first_screen(study))
    assert re.search(r"GM arcsec: 1\.\d+ ± [\d.]+ %  T s: [12]\.\d+ \(", first_screen(study, brief=True))
    told = replace(study, recipe=replace(study.recipe, device="stabilizer"))
    assert "causes in a gyro stabilizer" in first_screen(told)
    ramp = replace(study.channels[0], noise=replace(study.channels[0].noise, fit=al.identify(al.simulate(
        al.Model("N 0.3 arcsec*sqrt(s), R 0.5 arcsec/s"), 4000, 40.0, rng=np.random.default_rng(1)))))  # fmt: skip
    for each, drawn in ((study, True), (replace(study, channels=(ramp,)), False)):
        assert ("blind to a ramp" in page(each)) is drawn


def test_the_command_says_it_and_the_recipe_holds_it(tmp_path):
    recorded, page = tmp_path / "gyro.csv", tmp_path / "page.html"
    model = al.N(0.1, "deg/sqrt(h)") + al.R(3000.0, "deg/h^2")
    al.write(al.simulate(model, 6000, 10.0, rng=np.random.default_rng(1), name="gz"), recorded)
    result = run("analyze", recorded, "--device", "fog", "--report", page, code=0)
    text = " ".join(result.stdout.split())
    assert "what it means: gz - White noise (angle random walk) dominates up to 4" in text
    assert "The drift is systematic" in text
    assert "R in a fiber-optic gyroscope: rate ramp (gz) - sources: slow monotonic change" in text
    assert "K in a fiber-optic" not in text
    html = page.read_text("utf-8")
    assert "Likely causes in a fiber-optic gyroscope" in html
    assert "IEEE 952: IEEE Std 952-1997" in html
    # the device is a part of the recipe
    recipe = al.Recipe(device="mems")
    study = al.analyze(recorded, recipe)
    assert al.from_dict(study.to_dict()).recipe == recipe
    refused(al.UsageError, "unknown device 'x'", lambda: al.Recipe(device="x"))
