"""The door of the Python interface: arguments of any type are taken, or refused in words, by every public function."""

import contextlib
import inspect
import math
import os
import sys
from fractions import Fraction
from functools import cache
from operator import attrgetter
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import allanite as al
from allanite.core.declared import misfit, parameters
from allanite.core.files import locked

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))
from generate.api import TOPICS, public_names  # the names that the reference of the documentation has
from tests.rows import paired, rows


@cache
def functions() -> dict[str, Any]:
    """Every public function, by the name that users type after ``al.``."""
    found = {}
    for name in " ".join(names for _, names in TOPICS.values()).split():
        thing = attrgetter(name)(al)
        inner = public_names(name) if isinstance(thing, ModuleType) else []
        found |= {name: thing} if not inner else {f"{name}.{one}": getattr(thing, one) for one in inner}
    return {name: thing for name, thing in found.items() if inspect.isfunction(thing)}


@cache
def values() -> dict[str, Any]:
    """Arguments that are right, by the names of their parameters."""
    rng = np.random.default_rng(1)
    model = al.N(0.3, "deg/sqrt(h)") + al.K(2.0, "deg/h/sqrt(h)")
    record = al.simulate(model, 2000, 10.0, rng=rng)
    return {
        "accelerometer": al.N(0.001, "m/s/sqrt(h)"), "after": record, "before": record, "claims": model,
        "data": {}, "difference": np.zeros(100), "durations": (20.0,), "executor": None, "factors": [1.0, 2.0],
        "gimbals": al.angle.gimbals(np.arange(100.0), latitude=1.0), "gyro": model, "latitude": 1.0,
        "m": np.array([1, 2]), "measured": np.zeros(100), "method": "mean", "model": model, "module": None,
        "noise": model, "path": Path("nowhere.csv"), "rate": 10.0, "record": record, "recipe": al.Recipe(),
        "results": "nowhere", "reference": np.zeros(100), "rng": rng, "row": al.statistics.STATISTICS["oadev"],
        "runs": 1000, "second": record, "sheet": "adis16470", "size": 1000, "source": record, "statistic": "oadev",
        "settings": al.signals.PathSettings((al.signals.Stage("ADC", 16, 300.0, "deg/s"),)), "tau": 1.0,
        "time": np.arange(100.0), "time_constant": 10.0, "times": [0.0, 1.0], "until": 100.0, "value": record,
    }  # fmt: skip


class Strange:
    """An object of no type that a function knows."""


def declared(name: str) -> dict[str, Any]:
    return parameters(functions()[name].__wrapped__)


def refused(name: str, arguments: dict[str, Any]) -> str:
    """What is said of arguments, none of which is silently taken for another."""
    with pytest.raises(al.AllaniteError) as caught:
        functions()[name](**arguments)
    return str(caught.value)


NAMED = {
    name: [p for p in inspect.signature(thing).parameters.values() if p.kind != p.VAR_KEYWORD]
    for name, thing in functions().items()
}
"""The parameters of every function."""

ANYTHING = {("testing.check_reader", "module"), ("run_batch", "executor")}
"""Parameters that take any object: a module, and what has a method `submit`."""

PLACES = [(name, one.name) for name, ones in NAMED.items() for one in ones if (name, one.name) not in ANYTHING]


@rows("name, parameter", PLACES)
def test_another_type_is_refused_by_name(name, parameter):
    hint = declared(name).get(parameter, Any)
    if typed := misfit(Strange(), hint):
        said = refused(name, {parameter: Strange()})
        assert said.startswith(f"{name.rpartition('.')[2]}: {parameter} must be {typed}, not ")
    else:
        others = {one.name: values()[one.name] for one in NAMED[name] if one.default is one.empty or one.name in SIZED}
        refused(name, {**others, parameter: Strange()})


HUGE = 10**400
LOST = al.Record(np.full(100, np.nan), 10.0, "deg/s", name="gz")
USUAL = al.Record(np.random.default_rng(1).normal(size=400), 10.0, "deg/s", name="gz")
STILL = al.Record(np.zeros(400), 10.0, "deg/s", name="gz")
GREAT = al.Record(1e300 * np.random.default_rng(1).normal(size=100), 10.0, "deg/s", name="gz")

ODD = [
    (lambda: al.whitened(LOST, al.N(1.0, "deg/sqrt(h)")), "'gz' has 0 samples that are not missing"),
    (lambda: al.whitened(GREAT, al.N(1.0, "deg/sqrt(h)")), "times as large as the model's noise"),
    *((lambda name=name: al.claims.DriftSettings(**{name: 5}), f"{name} must be a text or a list of texts, not 5")
      for name in ("maneuver", "require", "turn_on")),
    (lambda: al.claims.DriftSettings(turn_on=None), "turn_on must be a text or a list of texts, not None"),
    (lambda: al.claims.DriftSettings(require=[1.0]), "require must be a text or a list of texts, not "),
    (lambda: al.claims.DriftSettings(times=HUGE), "not a number of more than 200 digits"),
    (lambda: al.Welch(segment=HUGE), "segment must be below 2.63, not a number of more than 200 digits"),
    (lambda: al.Recording("abc"), "Recording: records must be a tuple of Records, not "),
    *((lambda value=value: al.Model(value), "Model: terms must be text or terms") for value in (0, None, ["N"])),
    (lambda: al.simulation.RingLaser(pulse=GREAT), "RingLaser: pulse must be a "),
    (lambda: al.simulation.faults.Dither({"a": 1}), "Dither: amplitude must be a number"),
    (lambda: al.attitude.attitudes([[1.0, 2.0]], [1.0, 0.0, 0.0, 0.0]), r"have the shape \(n, 3\), not \(1, 2\)"),
    (lambda: al.attitude.attitudes(np.zeros((2, 3)), [1.0]), r"a quaternion of 4 numbers, not of the shape \(1,\)"),
    (lambda: al.attitude.Inertial(np.zeros((9, 3)), np.ones((4, 3)), 1.0), r"one shape \(n, 3\), but force"),
    (lambda: al.angle.Ring({"a": 1}, 0.0, 1.0), "Ring: rate must be a number"),
    (lambda: al.from_dict(al.angle.Harmonics.of({1: (1.0, 0.0)}).to_dict() | {"covariance": [[1.0]]}), "two equal"),
    (lambda: al.signals.PathSettings(("ADC",)), "PathSettings: stages must be a tuple of Stages, not "),
    (lambda: al.constant_rate.ExperimentSettings(methods=1j), "ExperimentSettings: methods must be a tuple of strings"),
    (lambda: al.constant_rate.ExperimentSettings(dither=5.0), "dither: expected numbers, e.g. 1,10,100, not 5"),
    (lambda: al.compensation.CompensationSettings(regressors=[5]), r"regressors: expected names, .*, not \[5\]"),
    (lambda: al.GM2("x", "deg/h", frequency=Fraction(HUGE)), "GM2: the numbers given are too large or too small"),
    *((lambda call=call: call(range(10**12)), "must have at most 10000000 items, not range")
      for call in (lambda x: al.Record(x, 10.0, "deg/s"), lambda x: al.deviation(LOST, m=x), al.attitude.attitudes)),
    (lambda: al.Accumulator(10.0, "deg/s").push(range(10**12)), "chunk must have at most 10000000 items"),
    (lambda: al.Accumulator(10.0, "deg/s").skip(2**62), "the number of missing samples must be between 0 and 9"),
    (lambda: al.Record(np.broadcast_to(1.0, 10**13), 1.0, "deg/s"), "Record: there is not enough memory"),
    (lambda: al.analyze(al.N(1.0, "deg/sqrt(h)")), "records must be a tuple of Records, not "),
    (lambda: al.residuals(STILL, al.identify(USUAL)), "'gz' never changes"),
    (lambda: al.state_space(al.K(1.0, "deg/h/sqrt(h)"), 1e15, tau=(1, 1e6)), "number of steps in the longest"),
    (lambda: al.Model("W 1 deg/h 10 s").structure(np.ones(2)), "a warm-up .* has no structure function"),
    (lambda: al.deviation(USUAL).to([1]), "Curve.to: unit must be a string"),
    (lambda: al.K(np.timedelta64(1, "s")), "K: value must be a number or a string, not "),
]  # fmt: skip
"""Calls with values of another type or size, and what is said of them."""


@rows("call, words", ODD)
def test_odd_values_are_refused_by_name(call, words):
    with pytest.raises(al.AllaniteError, match=words):
        call()


def test_a_lock_that_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe"):
        with pytest.raises(FileExistsError, match="not a file"):
            locked(path)


def test_samples_that_a_mask_hides_are_missing():
    x = np.ma.masked_array(np.random.default_rng(1).integers(0, 99, 600), mask=np.arange(600) > 500)
    stream = al.Accumulator(10.0, "deg/s")
    stream.push(x)
    plain, masked = (al.identify(y, rate=10.0, unit="deg/s") for y in (np.c_[x.data, x.data], np.ma.stack([x, x], 1)))
    assert np.isnan(al.Record(x, 10.0, "deg/s").values).sum() == stream.missing == 99
    assert repr(plain["1"]) != repr(masked["1"])


def test_a_stream_of_which_almost_all_is_missing_has_no_coefficients():
    stream = al.Accumulator(10.0, "deg/s")
    for _ in range(2):
        stream.push(np.arange(500.0))
        stream.skip(2**40)
    with pytest.raises(al.DataError, match="samples are"):
        stream.fit()


def test_values_that_say_nothing_are_no_error():
    record = al.Record(np.random.default_rng(1).normal(size=200), 10.0, "deg/s")
    assert al.identify(record, masks=np.array([])).method == al.identify(record, masks=[]).method
    assert al.deviation(record, noise=al.N(0.0, "deg/sqrt(h)")).tau.size
    assert np.isnan(al.simulation.faults.noise_profile(LOST, [0.0], [1.0]).values).all()


SIZED = ("rate", "size")  # parameters without which a model alone says nothing, although they have a default


@rows("size, statistic", paired([100, 256], al.statistics.STATISTICS))
def test_a_missing_sample_of_a_short_record_is_no_internal_error(statistic, size):
    samples = np.random.default_rng(size).normal(size=size)
    samples[size // 2] = np.nan
    with contextlib.suppress(al.AllaniteError):
        assert al.deviation(al.Record(samples, 10.0, "deg/h"), statistic, noise=None).statistic == statistic


def nested() -> list[Any]:
    """A list that contains itself."""
    itself: list[Any] = []
    itself.append(itself)
    return itself


MODEL, RECORD = values()["model"], values()["record"]
EXTREME = [
    (lambda: al.N(1e300, "deg/sqrt(h)"), "value must be between"),
    (lambda: al.N(1e40, "deg/sqrt(h)"), "cannot be computed with"),
    (lambda: al.N(1e-300, "deg/sqrt(h)"), "value must be between"),
    (lambda: al.Record([1.0, 2.0], 10**400, "deg/h"), "a number of more than 200 digits"),
    (lambda: al.spectrum(RECORD, bins=10**9), "omit it to have all"),
    (lambda: al.deviation(RECORD, taus=[1e300]), "averaging times"),
    (lambda: al.expected(MODEL, "oadev", 0.0), "averaging times"),
    (lambda: al.expected(MODEL, "oadev", 1e300), "tau must be between"),
    (lambda: al.simulate(MODEL, 10**12, 10.0, rng=1), r"between 2 and 1e\+10"),
    (lambda: al.simulate(MODEL, 10, 10.0, rng=-1), "a seed must be between 0 and"),
    (lambda: al.simulate(MODEL, rate=1.0, duration=math.inf, rng=1), "duration must be"),
    (lambda: al.bound(MODEL, rate=1.0, duration=math.nan), "duration must be"),
    (lambda: al.selfcheck(MODEL, 100, math.nan, rng=1), "sampling rate must be"),
    (lambda: al.averaging_stability(RECORD, 10**30), "below 2"),
    (lambda: al.averaging_stability(RECORD, math.nan), "not a multiple"),
    (lambda: al.simulation.faults.quantize_rate(RECORD, 5e-324, "deg/s"), "lsb must be between"),
    (lambda: al.attitude.kalman(-1.0, 1.0), "N must be between 0"),
    (lambda: al.statistics.edf(al.STATISTICS["oadev"], MODEL, [0], 100, 10.0), "averaging factors"),
    (lambda: al.statistics.covariance(al.STATISTICS["oadev"], MODEL, [1], -1, 10.0), "needs at least 2"),
    (lambda: al.drift(nested()), "nested too deeply"), (lambda: al.read("x" * 5000), "5000 characters"),
    (lambda: al.selfcheck(MODEL, 1000, 10.0, level=2.0, rng=1), "level"),
    (lambda: al.analyze(al.Record(np.arange(1000) % 7, 10.0, "arcsec", kind="count", scale=1e308)), "scale"),
]  # fmt: skip


@rows("call, words", EXTREME)
def test_a_number_out_of_range_is_refused_before_any_work(call, words):
    with pytest.raises(al.AllaniteError, match=words):
        call()


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.binary(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)


@given(st.sampled_from(PLACES), anything)
def test_any_value_of_another_type_is_refused(place, value):
    name, parameter = place
    hint = declared(name).get(parameter, Any)
    if misfit(value, hint):
        assert refused(name, {parameter: value}).startswith(f"{name.rpartition('.')[2]}: {parameter} must be ")
