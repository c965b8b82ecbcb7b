"""The public names as a user types them: checked by mypy, never run."""

from pathlib import Path
from typing import assert_type

import numpy as np
from matplotlib.figure import Figure

import allanite as al

rng = np.random.default_rng(1)
term = al.N(0.3, "deg/sqrt(h)")
assert_type(term, al.Term)
model = term + al.B(1.0, "deg/h")
assert_type(model, al.Model)
assert_type(al.Model("N 0.3 deg/sqrt(h)"), al.Model)
assert_type(al.sensor("fog"), al.Model)

recording = al.read("gyro.csv", rate=100.0, unit="deg/s", channels=["gx"])
assert_type(recording, al.Recording)
assert_type(recording["gx"], al.Record)
assert_type(al.write(recording, "copy.npz", force=True), None)
record = al.Record(np.zeros(1000), rate=100.0, unit="deg/s")
assert_type(record, al.Record)
assert_type(al.simulate(model, 1000, 100.0, rng=rng), al.Record)
assert_type(al.simulation.simulate_ring_laser(al.simulation.GL1, 12.0, 1000, 400.0, rng=rng), al.Record)

curve = al.deviation(record, "oadev", taus="log", noise=model)
assert_type(curve, al.Curve)


assert_type(al.dynamic(record, window=60.0), al.statistics.Surface)
assert_type(al.spectrum(record, "multitaper"), al.Spectrum)

assert_type(al.deviation(np.zeros(1000), rate=100.0, unit="deg/s"), al.Curve)
assert_type(al.spectrum(np.zeros(1000), fs=100.0), al.Spectrum)
assert_type(al.identify(np.zeros(1000), rate=100.0, unit="deg/s", terms=["N", "K"]), al.Fit)
assert_type(al.simulate(model, rate=100.0, duration=60.0, rng=1), al.Record)

fit = al.identify(record, terms="auto")
assert_type(fit, al.Fit)
assert_type(al.identify(curve, "gls"), al.Fit)
assert_type(al.identify(recording), dict[str, al.Fit])
assert_type(fit["N"], al.Estimate)
assert_type(fit["N"].value, float | None)
assert_type(fit["N"].interval(0.95), tuple[float, float])
assert_type(fit.model, al.Model)
assert_type(al.residuals(record, fit), al.identification.Residuals)
assert_type(al.shared(recording, {"gx": fit}), al.identification.Shared)

study = al.analyze(Path("gyro.csv"), al.Recipe(rate=100.0, unit="deg/s"))
assert_type(study, al.Study)
comparison = al.compare("before.csv", record, rng=rng)
assert_type(comparison, al.Comparison)
assert_type(al.comparison.pool([record, recording, "third.csv"]), al.comparison.Pool)
assert_type(al.comparison.truncation(record, 600.0), al.Comparison)
assert_type(al.plot(study, path="curve.png"), Figure)
assert_type(al.report(study, "page.html", force=True), None)

assert_type(al.state_space(model, 100.0, tau=(1.0, 1000.0)), al.StateSpace)
assert_type(al.export([study, model], "kalibr", rate=100.0), al.Export)
assert_type(al.read_noise("imu.yaml", "kalibr"), al.exporting.Imported)
assert_type(al.plan(model, 100.0, durations=[3600.0]), al.planning.RecordingPlan)
assert_type(al.bound(model, 1000, 100.0), al.planning.Bound)
assert_type(al.selfcheck(fit, 1000, 100.0, rng=rng), al.planning.SelfCheck)
assert_type(al.compensate(record, recording, ["temp"]), al.compensation.Regression)
assert_type(al.signals.budget(record, [al.signals.Stage("ADC", 16, 300.0, "deg/s")]), al.signals.Budget)
assert_type(al.signals.rate_from_current(record, 0.2), al.Record)
assert_type(al.constant_rate.estimate(record, "optimal", model=model), al.constant_rate.RateEstimate)
assert_type(al.prepare.trim(recording, 0.0, 60.0), al.Recording)
