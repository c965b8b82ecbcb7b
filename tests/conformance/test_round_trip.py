"""Every result travels: through pickle, and through JSON text, with its intervals, and `repr` is one line."""

import dataclasses
import importlib
import json
import pickle
import pkgutil
import subprocess
import sys
import tempfile
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from tests import thinned
from tests.rows import refused, rows

import allanite as al
from allanite.applications.angle import Solution
from allanite.applications.attitude.scenarios import VerticalDesign
from allanite.applications.compensation import FitSettings, compensate
from allanite.applications.compensation.compensating import compensate_file
from allanite.applications.compensation.settings import CompensationSettings
from allanite.applications.constant_rate import closeup
from allanite.applications.constant_rate.campaign import RateSettings, measure_rates
from allanite.applications.signals import TorqueScale
from allanite.applications.signals.budgeting import PathSettings
from allanite.applications.signals.stage import codes
from allanite.batch.lot import Outlying, Trend
from allanite.claims.claim import claim_of
from allanite.comparison.comparison import ComparisonSettings
from allanite.core.correction import Correction
from allanite.core.estimate import averaged
from allanite.core.fit import Alternative
from allanite.core.plain import TYPES, Portable, Value
from allanite.core.validity import Finding
from allanite.exporting.imported import Explanation, noise_in
from allanite.interpretation.glossary import words
from allanite.interpretation.sentences import meaning
from allanite.papers.paper import compare, read_paper
from allanite.planning.plan import properties
from allanite.prepare import inspect
from allanite.simulation.record import Simulation
from allanite.statistics import Expectations, expectation
from allanite.study.modelled import PlanSettings, SelfCheckSettings, StateSpaceSettings, run_model_job
from allanite.study.survey import Densities, Deviations, TheorySettings, Windows, survey
from allanite.terms import TERMS

LEVEL = 0.9
WHITE_AND_WALK = [al.Model("N 0.1 deg/sqrt(h), K 1 deg/h/sqrt(h)"),
                  al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")]  # fmt: skip
MODEL = al.N(0.01, "deg/sqrt(h)") + al.B(0.5, "deg/h") + al.Sine(3, "deg/h", frequency=0.5)


PAPER = """title = "a paper"
source = "an author"
data = "none"
commands = []
captions = {}
items = [{item = "eq. 5", claim = "a claim", paper = "3", verdict = "misprint", why = "it is 4"}]"""


@cache
def record(i=0):
    noise = MODEL if i < 3 else MODEL + al.R(2000.0, "deg/h^2")
    return dataclasses.replace(al.simulate(noise, 16384, 100.0, rng=i), name=f"z{i}")


@cache
def fit(method="whittle", i=0):
    return al.identify(record(i), method=method, **({"terms": "QNBKR,GM"} if method == "whittle" else {}))


@cache
def filtered():
    """A fit behind a filter."""
    quiet = al.simulate(al.N(0.1, "deg/sqrt(h)"), 16384, 100.0, rng=1, name="z")
    return al.identify(al.simulation.faults.low_pass(quiet, 12.0), terms="NB")


def curve(statistic="oadev", **options):
    return al.deviation(record(), statistic, **({"noise": fit().model} | options))


@cache
def batch():
    """Two units, of which one fails and one is not there, with limits."""
    limits = {"limits": {"N": {"max": "0.005 deg/sqrt(h)"}, "minimum": {"max": "9 deg/h"}},
              "channels": {"z1": {"B": {"max": "1 deg/h"}}}}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        al.write(record(), f"{folder}/unit.npz")
        files = [f"{folder}/unit.npz", f"{folder}/missing.npz"]
        return al.batch.analyze_files(files, al.Recipe(level=LEVEL), limits=al.batch.Specification.from_toml(limits))


@cache
def lot():
    """A unit of stored results."""
    with tempfile.TemporaryDirectory() as folder:
        al.write(record(), f"{folder}/unit.npz")
        al.batch.run_batch(f"{folder}/*.npz", f"{folder}/results", al.Recipe(level=LEVEL))
        return al.batch.read_lot(f"{folder}/results")


WHITE = "N 0.1 deg/sqrt(h)"
GIVEN = al.Recipe(rate=100.0)


@cache
def study():
    flat = al.Record(np.zeros(16384), 100.0, "deg/h", name="flat")
    return al.analyze(al.Recording((record(0), record(1), flat)), al.Recipe(level=LEVEL))


def surveyed(settings):
    return survey(record(), settings, al.Recipe(level=LEVEL))


@cache
def day():
    temp = al.Record(20 + 5 * np.sin(np.arange(1200) / 200), 1.0, "degC", name="temp")
    noise = al.simulate(al.N(0.1, "deg/sqrt(h)"), temp.size, 1.0, rng=2)
    return al.Recording((noise.with_values(noise.values + 1e-5 * temp.values, "warmed"), temp))


@cache
def regression():
    return compensate(day()[0], day(), ["temp"], degree=2, settings=FitSettings(terms="N", every=True))


@cache
def compensation():
    warm = day()
    settings = CompensationSettings(("temp",), fit=FitSettings(terms="N"))
    with tempfile.TemporaryDirectory() as folder:
        path, heads = f"{folder}/day.csv", "time [s],gx [deg/h],flat [deg/h],temp [degC]"
        rows = np.column_stack((np.arange(1200), np.degrees(warm[0].values) * 3600, np.zeros(1200), warm[1].values))
        np.savetxt(path, rows, "%.9g", ",", header=heads, comments="")
        return compensate_file(path, al.Recipe(level=LEVEL, outliers="mark"), settings, apply_to=path)


@cache
def rounded(torquer=TorqueScale(100, 0.4, 0.05, 0.05, 2e-3, 1000.0, 4)):  # noqa: B008 - a frozen value
    stage = al.signals.Stage("ADC", 12, 5.0, "V")
    volts = 5 * al.simulate(al.N(2.5, "deg/sqrt(h)"), 4000, 1000.0, rng=1).values / 0.2
    columns = {"ux": np.rint(volts / stage.step) * stage.step, "flat": np.zeros(4000)}
    recording = al.Recording(tuple(al.Record(values, 1000.0, "V", name=name) for name, values in columns.items()))
    settings = PathSettings((stage, al.signals.Stage("output", 16, 500.0, "deg/s")), torquer, 5.0)
    return al.signals.budget_file(recording, al.Recipe(terms="QN", level=LEVEL), settings)


@cache
def plan_of_angles():
    ring = al.angle.Ring(1e-4, -0.1, 0.1)
    return al.angle.AngleSettings(np.radians(60), duration=1800.0, interval=30.0, sway=(0.01, 10.0), ring=ring)


@cache
def calibration():
    gimbals = al.angle.gimbals(np.arange(7200.0, 10800.0, 30.0), latitude=np.radians(60))
    true = {"h": al.angle.Harmonics.of({128: (3e-6, 0.0)})}
    z = al.angle.simulate(gimbals, true, sigma=1e-6, rng=np.random.default_rng(1))
    return al.angle.estimate(z, gimbals, prior=(1e-5, 1e-5))


@cache
def rate_study():
    noise = al.N(0.1, "deg/sqrt(h)") + al.Q(5, "arcsec")
    up, down = (al.simulate(noise, 4096, 100.0, rng=i) for i in range(2))
    settings = RateSettings(al.constant_rate.ExperimentSettings(interval=5.0), noise, latitude=55.8, durations=(2.0,))
    return measure_rates(up, al.Recipe(level=LEVEL), settings, second=down)


@cache
def level():
    rng = np.random.default_rng(1)
    noise = 3 * [al.N(0.3, "deg/sqrt(h)")] + 3 * [al.N(100, "ug/sqrt(Hz)")]
    records = [al.simulate(n, 6000, 10.0, rng=rng, name=name) for n, name in zip(noise, "pqrxyz", strict=True)]
    up = dataclasses.replace(records[5], values=records[5].values + 9.81)
    return al.attitude.vertical(al.Recording((*records[:5], up)))


def trial():
    noise = al.N(0.3, "deg/sqrt(h)"), al.N(100, "ug/sqrt(Hz)")
    return al.attitude.Trial(*noise, bias=(1e-5, 0.0, -1e-5), rate=10.0, duration=60.0)


claim_check = cache(lambda: al.check(record(), "N 0.02 deg/sqrt(h), B 0.5 deg/h"))
comparison = cache(lambda: al.compare(record(0), record(3), rng=np.random.default_rng(1)))
drifts = cache(lambda: al.drift(study(), require=["1 deg in 10 min"]))
exported = cache(lambda: al.export(WHITE_AND_WALK, "kalibr", rate=100.0))
pool = cache(lambda: al.comparison.pool([record(i) for i in range(3)], rng=np.random.default_rng(1)))
read = cache(lambda: al.readings(record()))
residuals = cache(lambda: al.residuals(record(), fit()))
scenario_errors = cache(lambda: al.attitude.compare_filters(trial(), rng=np.random.default_rng(1)))
selfcheck = cache(lambda: al.selfcheck(al.N(0.1, "deg/sqrt(h)"), 2000, 10.0, records=3, rng=1, terms="NB"))

PARTS = {
    plan_of_angles: {"AngleSettings": "", "Ring": "ring", "Sway": "sway"},
    batch: {"Batch": "", "BatchUnit": "0", "BatchUnit that failed": "1", "Across": "across.1",
            "Judgement": "0.judgements.0", "Specification": "specification", "Limit": "specification.limits.0"},
    lot: {"Lot": "", "Distribution": "distributions.0"},
    rounded: {"BudgetStudy": "", "BudgetChannel": "0", "BudgetChannel that is refused": "1", "Budget": "0.budget",
              "StageNoise": "0.budget.stages.0", "PathSettings": "settings", "TorqueScale": "settings.torquer"},
    calibration: {"Calibration": "", "Gimbals": "gimbals", "Solution": "solution", "SquareRoot": "solution.known",
                  "History": "solution.history", "InnovationTest": "solution.checks.0"},
    comparison: {"Comparison": "", "Change": "N", "Change of a signed term": "R", "Pair": "pairs.0",
                 "Homogeneity": "pairs.0.test", "Ratios": "pairs.0.ratios"},
    pool: {"Pool": "", "PooledChannel": "channels.0", "PooledTerm": "terms.0"},
    claim_check: {"ClaimCheck": "", "Cause": "causes.0", "CheckedTerm": "terms.0"},
    compensation: {"CompensationStudy": "", "Compensated": "0", "Compensated that is refused": "1",
                   "Compensated that was held back": "applied.0", "Gain that was held back": "applied.0.gain"},
    regression: {"Regression": "", "Gain": "inside", "Mixture": "mixture", "Regressor": "regressors.1"},
    record: {"Header": "header"},
    fit: {"Fit": "", "Estimate": "N", "Estimate that is absent": "K", "Goodness": "goodness", "Line": "lines.0"},
    filtered: {"Component": "components.0", "Scope": "scope", "LowPass": "scope.filter"},
    residuals: {"Residuals": "", "Check": "checks.0"},
    read: {"Readings": "", "Reading": "usual", "Means": "means.0", "Slope": "slopes.0"},
    level: {"VerticalStudy": "", "VerticalChannel": "channels.2", "Angle": "angles.0", "Optimum": "angles.0.optimum",
            "Prediction": "angles.0.prediction", "Source": "angles.0.prediction.sources.0"},

    rate_study: {"RateStudy": "", "RateChannel": "channels.0", "RateEstimate": "channels.0.bias",
                 "Experiment": "channels.0.experiment"},
    exported: {"Export": "", "Entry": "entries.0", "StatedNoise": "stated.0"},
    drifts: {"Drift": "", "DriftAxis": "axes.0", "DriftCause": "axes.0.causes.0"},
    selfcheck: {"SelfCheck": "", "TermCheck": "terms.1"},
    study: {"Study": "", "Channel": "channels.0", "Channel that is refused": "channels.2"},

}  # fmt: skip
"""What makes a result, and where the values of each type are in it."""


def part_of(make, path):
    value = make()
    for step in filter(None, path.split(".")):
        value = getattr(value, step) if hasattr(value, step) else value[int(step) if step.isdigit() else step]
    return value


PLAIN = (
    Alternative(MODEL, -3.5), Outlying("z0", "N", MODEL.signal, "unit.npz", 2.0, 1.0),
    Trend("z0", "N", MODEL.signal, "date", np.arange(9.0), np.ones(9), 1.0, 0.5, 1.5),
    CompensationSettings(("temp",), lags=(60.0,), fit=FitSettings(smooth=90.0)),
    ComparisonSettings(against=("x", "y"), part=10.0), Densities(bins=5), Deviations(("adev",), m=(1, 2)),
    al.attitude.Loop(0.9, 0.016), al.attitude.VerticalSettings("mahony", 2.0, gate=1.0),
    al.constant_rate.EstimatorSettings(lines=3, allowed=1e-9),
    al.constant_rate.ExperimentSettings(methods=("mean",), dither=(400.0,)),
    Finding("gaps", "10 samples are missing", place=(0.5, 1.0)), FitSettings(terms="NK", least=3.0), MODEL,
    PlanSettings(model="N 0.01 deg/sqrt(h)", durations=(600.0,), ramp=True),
    al.claims.DriftSettings(turn_on=("3 deg/h",)), Explanation("kalibr"),
    al.planning.DATASHEETS["ADIS16470"].claims[0], al.planning.DATASHEETS["BMI088"],
    RateSettings(noise=MODEL, signal=MODEL.signal, horizontal=True, latitude=55.8),
    SelfCheckSettings(sensor="fog", duration=600.0, max_bias=0.05), al.signals.Stage("ADC", 12, 5.0, "V"),
    StateSpaceSettings(sensor="fog", order=3, turn_on="3 deg/h"), MODEL["Sine"],
    TheorySettings(model=WHITE, duration=60.0), Windows(window=10.0),
)  # fmt: skip
"""Values that nothing has to be computed for."""

MAKERS = {
    **{type(value).__name__: lambda value=value: value for value in PLAIN},
    **{name: partial(part_of, make, path) for make, parts in PARTS.items() for name, path in parts.items()},
    "AnglePlan": lambda: al.angle.plan(plan_of_angles(), 7200.0),
    "Averaged": lambda: averaged([MODEL, al.Model(MODEL.terms[:1])], [3, 1]),
    "Bound": lambda: al.bound(MODEL, 20_000, 100.0),
    "BudgetStudy with a scale factor": lambda: rounded(0.2),
    "Codes": lambda: codes(np.repeat([0.0, 1.0, 3.0, 4.0], 50)),
    "Compared": lambda: compare(read_paper("000", PAPER), Path()).items[0],
    "ClaimedSetting": lambda: al.claims.claim_of("gyro lowpass 42 Hz").settings[0],
    "Comparison of fits": lambda: al.compare(fit(), fit(i=3)),
    "Curve": curve,
    "Curve of an average": lambda: curve(noise=averaged([MODEL, al.Model(MODEL.terms[:1])], [3, 1])),
    "Curve of a found power law": lambda: curve(noise="auto"),
    "Curve without limits": lambda: curve(noise=None),
    "Curve of many points": lambda: curve(taus="all"),
    "Effect": lambda: regression().effect(0, LEVEL),
    "Estimate of a ramp": lambda: fit(i=3)["R"],
    "Estimate that is not valid": lambda: fit()["N"].invalid("the curve contradicts it"),
    "Trial": trial,
    "ScenarioErrors": scenario_errors,
    "VerticalDesign": lambda: VerticalDesign(level().angles[0].optimum, scenario_errors()),
    "Estimate with a shape": lambda: next(e for e in fit(i=0) if TERMS[e.symbol].parameters),
    **{f"Fit by {method}": partial(fit, method) for method in al.identification.METHODS if method != "whittle"},
    "Measured": lambda: surveyed(Deviations(("adev", "totdev"))).channels[0],
    "North": lambda: al.constant_rate.north(rate_study().channels[0].bias, 55.8),
    "Quality": lambda: inspect(al.Record(np.full(300, 1.25), 10.0, "deg/h")),
    "Ranking": lambda: al.constant_rate.rank(al.N(0.1, "deg/sqrt(h)"), size=1000, rate=100.0),
    "Meaning": lambda: meaning(fit(), read(), rate=100.0, length=163.84, device="mems"),
    "Word": lambda: words()["bias instability"],
    "Reproduction": lambda: compare(read_paper("000", PAPER), Path()),
    "SheetComparison": lambda: al.comparison.compare_with_sheet(record(), "adis16470", al.Recipe(level=LEVEL)),
    "Export of matrices": lambda: al.export(WHITE_AND_WALK[0], "statespace", rate=100.0),
    "ClaimedNoise": lambda: claim_of("N 0.3 deg/sqrt(h); 100 ug/sqrt(Hz)"),
    "Imported": lambda: noise_in(exported().text, al.exporting.EXPORTS["kalibr"], None),
    "Recording": lambda: al.Recording((record(), record(1)), source="a.csv"),
    "RecordingPlan": lambda: al.plan(MODEL, 100.0),
    "RecordingPlans": lambda: run_model_job(record(), PlanSettings(), al.Recipe(level=LEVEL)),
    "RecordingPlans of a given model": lambda: run_model_job(None, PlanSettings(sensor="fog"), GIVEN),
    "Properties": lambda: properties("theo1", 200),
    "Closeup": lambda: closeup(al.simulation.simulate_ring_laser(al.simulation.GL1, 12.0, 2000, 400.0, rng=1)),
    "Expectation": lambda: expectation(al.Model(WHITE), rate=10.0, size=200),
    "Expectations": lambda: Expectations((expectation(al.Model(WHITE), rate=10.0, size=200),) * 2),
    "Scan": lambda: al.angle.scan(plan_of_angles(), [7200.0, 9000.0]),
    "SelfChecks": lambda: run_model_job(None, SelfCheckSettings(model=WHITE, samples=2000, records=3), GIVEN),
    "Shared": lambda: al.shared(al.Recording((record(0), record(1))), {f"z{i}": fit(i=i) for i in range(2)}),
    "Simulation": lambda: Simulation.of(MODEL, 1, al.Recording((record(),))),
    "Spectrum": lambda: al.spectrum(record()),
    "StateSpace": lambda: al.state_space(MODEL, 100.0),
    "StateSpace of discrete time": lambda: al.state_space(al.N(0.1, "deg/sqrt(h)") + al.Q(1.0, "arcsec"), 100.0),
    "StateSpaces": lambda: run_model_job(None, StateSpaceSettings(sensor="fog"), GIVEN),
    "Study by another method": lambda: al.analyze(record(), al.Recipe(method="gls", level=LEVEL)),
    "Surface": lambda: al.dynamic(record(), "oadev", window=40.0, step=20.0, noise=fit().model),
    "Survey": lambda: surveyed(Deviations(intervals=False)),
    "Survey of spectra": lambda: surveyed(Densities(fit=True)),
    "Survey of surfaces": lambda: surveyed(Windows(window=40.0)),
}
"""A name that begins with the type: what makes one."""


def text_of(value):
    return json.dumps(value.to_dict(LEVEL), allow_nan=False)


def same(one, other):
    """Whether two values have equal fields, as far as they can be compared."""
    if callable(one) or callable(other):  # worked out when asked for: the values are in the text
        return all(part is None or callable(part) for part in (one, other))
    if isinstance(one, al.Record):
        return one.header == getattr(other, "header", other)
    if isinstance(one, Portable):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one) if f.compare)
    if isinstance(one, dict):
        one, other = list(one.items()), list(other.items())
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, (np.ndarray, float)):
        return np.array_equal(one, other, equal_nan=True) and np.shape(one) == np.shape(other)
    return one == other


def intervals(value):
    if isinstance(value, Solution):
        return [np.asarray(value.interval(name, LEVEL)) for name in value.names]
    known = callable(getattr(value, "interval", None)) and getattr(value, "law", 0) is not None
    return [np.asarray(limit) for limit in (value.interval(LEVEL) if known else ())]


def alike(one, other):
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(intervals(one), intervals(other), strict=True))


@cache
def made(name):
    return MAKERS[name]()


@rows("name", thinned(MAKERS, 5))
def test_whatever_is_changed_it_is_read_or_refused_in_words(name):
    """The first mutants of which `benchmarks/fuzz.py` tries many more; what is read is exported, too."""
    from tests import hostile

    for k, changed in hostile.mutants(name, json.loads(text_of(made(name))), 25):
        assert hostile.judged(hostile.taken_back, changed, k) in {"taken", "refused"}, k


@pytest.mark.slow("makes a result of every kind")
@rows("name", MAKERS)
def test_a_value_travels(name):
    value = made(name)
    text = text_of(value)
    pickled, stored = pickle.loads(pickle.dumps(value)), al.from_dict(json.loads(text))
    for again in (pickled, stored):
        assert type(again) is type(value)
        assert type(value).__name__ == name.split()[0]
        assert same(value, again)
        assert text_of(again) == text
        assert alike(value, again)
        assert repr(again) == repr(value)
    assert "\n" not in repr(value)
    assert len(repr(value)) < 160


def classes(base):
    """The classes below one that have none below them."""
    below = base.__subclasses__()
    return [leaf for one in below for leaf in classes(one)] if below else [base]


def test_every_class_that_is_written_can_be_read():
    for module in pkgutil.walk_packages(al.__path__, "allanite."):
        if not module.name.endswith("__main__"):
            try:
                importlib.import_module(module.name)
            except ModuleNotFoundError as error:  # the library of an extra
                if error.name.partition(".")[0] in ("allanite", "numpy", "scipy"):
                    raise
    own = {cls.__name__: cls for cls in classes(Value) if cls.__module__.startswith("allanite.")}
    tried = {name.split()[0] for name in MAKERS} | {"Harmonics"}  # a correction, tried beside what estimates it
    others = {cls.__name__ for cls in own.values() if "to_dict" in vars(cls)} - tried  # they write another type
    assert tried == own.keys() - others | {"BatchUnit", "Study"}  # read again when it is asked for; has a kind
    assert all(TYPES[name] is cls for name, cls in own.items())
    for cls in own.values():
        assert cls.__repr__ is Value.__repr__ or issubclass(cls, Correction)


@pytest.mark.slow("takes more than half a second")
def test_a_type_is_found_before_its_module_is_imported():
    names = {name.split()[0] for name in MAKERS}
    for order in (sorted(names), sorted(names, reverse=True)):
        program = f"from allanite.core.plain import class_of\nfor name in {order}: class_of({{'type': name}})"
        subprocess.run([sys.executable, "-c", program], check=True)


def test_limits_at_another_level_are_refused():
    stored = al.from_dict(fit().to_dict(LEVEL))
    refused(al.UsageError, r"were stored for level 0\.9, not 0\.95", lambda: stored["N"].interval(0.95))
    again = al.Curve.from_dict(curve().to_dict(LEVEL))
    refused(al.UsageError, r"were stored for level 0\.9, not 0\.5", lambda: again.interval(0.5))


def test_a_comparison_is_read_with_limits_of_any_level_and_the_headers_of_its_records():
    stored = al.from_dict(json.loads(json.dumps(comparison().to_dict(0.8))))
    assert stored.verdict == comparison().verdict
    assert stored["K"].interval(0.8) == comparison()["K"].interval(0.8)
    assert stored.pairs[0].records == (record(0).header, record(3).header)
    assert al.Record.from_dict(record().to_dict()) == record().header


@rows("data, words", [
    ({"type": "Kurve"}, "unknown type 'Kurve' of stored data; did you mean Curve"),
    ([], "without a type cannot be read"), ({"type": "Finding", "name": "gaps"}, "the stored Finding has no 'what'"),
    ({"allanite": 2, "type": "Finding", "name": "gaps"}, "version 2; this program reads version 1"),
])  # fmt: skip
def test_what_cannot_be_read_is_said(data, words):
    refused(al.UsageError, words, lambda: al.from_dict(data))
    with pytest.raises(al.UsageError):
        al.Curve.from_dict(MODEL.to_dict())


CHANGED = [
    ("StateSpace", "Phi", [[1.0] * 9] * 9, "not of one size"),
    ("StateSpace", "H", [["inf"]], "not finite|a list of numbers"),
    ("StateSpace", "tau", [1.0, "inf"], "number of steps"),
    ("Spectrum", "sides", "__class__", "sides: unknown side"),
    ("Curve", "variance", [-1.0], "variance: a number between 0"),
    ("Ranking", "errors", {}, "errors: the stored value has no 'optimal'"),
    ("Residuals", "level", [1.0], "level, level_error must have as many items"),
]


@rows("kind, key, value, words", CHANGED)
def test_parts_that_do_not_agree_are_refused_by_their_field(kind, key, value, words):
    name = next(name for name in MAKERS if name.split()[0] == kind)
    refused(al.UsageError, words, lambda: al.from_dict(json.loads(text_of(made(name))) | {key: value}))


def test_a_stored_recording_is_shown_without_its_samples():
    stored = al.from_dict(json.loads(json.dumps(al.Recording((record(),)).to_dict())))
    assert "100 Hz" in stored.summary()
    assert "Samples over time" in stored._repr_html_()
    refused(al.UsageError, "has no samples: read its file once more", stored.to_dataframe)


def test_nan_and_none_and_infinity_are_told_apart():
    estimate = dataclasses.replace(fit()["N"], value=np.nan, standard_error=None, upper=np.inf, shape=(-np.inf, np.nan))
    again = al.from_dict(json.loads(json.dumps(estimate.to_dict(), allow_nan=False)))
    assert (again.standard_error, again.upper, again.shape[0]) == (None, np.inf, -np.inf)
    assert np.isnan([again.value, again.shape[1]]).all()


def test_a_pickle_holds_no_more_than_it_must():
    # the readings are not in the limits of a curve, nor in those of a fit
    assert len(pickle.dumps(curve(noise="auto"))) < 20_000
    assert len(pickle.dumps(fit())) < 400_000
