"""Temperature polynomials: the formula of each autopilot, applied to its file, is the correction of the regression."""

import dataclasses

import numpy as np
import pytest
from tests.rows import paired, refused, rows
from tests.unit.exporting import parsers

import allanite as al
from allanite.applications.compensation.compensating import Compensated, CompensationStudy
from allanite.applications.compensation.mixture import Gain, Mixture
from allanite.applications.compensation.regression import Regression
from allanite.applications.compensation.regressor import Regressor
from allanite.applications.compensation.settings import CompensationSettings
from allanite.core.units import SIGNALS
from allanite.exporting.temperature import polynomial

LOW, HIGH = 12.0, 61.0
SENSORS = {"gyro": SIGNALS[0], "accelerometer": SIGNALS[1]}
CENTRES, POWERS = (20.0, 35.0, 47.123), ((1,), (1, 2), (1, 3), (1, 2, 3))
SEEN = np.linspace(LOW, HIGH, 23)


def regression(signal=SIGNALS[0], name="gx", powers=(1, 2, 3), centre=40.0, *, share=0.5, span=(LOW, HIGH), **changes):
    """A regression with coefficients of 0.01 SI over the range, all of them significant unless `share` is 0."""
    regressors = [dataclasses.replace(Regressor("temp", "degC", centre, k, span=span), **changes) for k in powers]
    p, sizes = len(regressors) + 1, np.array([0.01 * (-1) ** k / 20.0**k for k in powers] + [1e-9])
    errors = np.abs(sizes) * (0.01 if share else 10)
    mixture = Mixture(np.ones(1), sizes[None], errors[None], np.diag(errors**2))
    return Regression(
        signal, name, (*regressors, Regressor("time", "s")), mixture,
        (False,) * p, 0, np.ones(p), 1.0, al.Model("N 0.1 deg/sqrt(h)"), 1e4, Gain(1.0, 1 - share, 0.0),
    )  # fmt: skip


def study(*regressions, unfit=()):
    channels = [Compensated(al.Record(SEEN, 1.0, r.signal.unit, name=r.name), r) for r in regressions]
    channels += [Compensated(al.Record(SEEN, 1.0, "rad/s", name=name), refusal="it moves") for name in unfit]
    source = {"source": "log.csv", "sha256": "1" * 64}
    return CompensationStudy(tuple(channels), al.Recipe(), (), (), source, (), CompensationSettings(("temp",)))


def values(text, separator):
    """Name -> value; in both forms the value stands behind the name."""
    rows = [line.split(separator)[2:4] if separator == "\t" else line for line in text.splitlines() if line[0] != "#"]
    return {name: float(value) for name, value in (r if isinstance(r, list) else r.split(",") for r in rows)}


@rows(("sensor", "centre", "powers"), paired(list(SENSORS), CENTRES, POWERS))
def test_the_correction_is_that_of_the_regression(sensor, centre, powers):
    made = [regression(SENSORS[sensor], f"w{axis}", powers, centre) for axis in "xyz"]
    made[1] = dataclasses.replace(made[1], mixture=made[1].mixture.scaled(-np.ones(len(powers) + 1), np.zeros(1)))
    px4, ardupilot = (al.exporting.temperature_parameters(study(*made), target) for target in ("px4", "ardupilot"))
    v, w = values(px4.text, "\t"), values(ardupilot.text, ",")
    temp = al.Recording((al.Record(SEEN, 1.0, "degC", name="temp"),))
    for axis, one in enumerate(made):
        wanted = one.rate_error(al.Record(SEEN, 1.0, one.signal.unit, name="w"), temp)
        bound = {"rtol": 0, "atol": 1e-13}
        np.testing.assert_allclose([parsers.px4_thermal_offset(v, sensor, axis, t) for t in SEEN], wanted, **bound)
        found = [parsers.ardupilot_thermal_offset(w, sensor, axis, t, centre) for t in SEEN]
        np.testing.assert_allclose(found, wanted, **bound)
        for beyond, end in ((-40.0, 0), (90.0, -1)):
            assert parsers.px4_thermal_offset(v, sensor, axis, beyond) == pytest.approx(wanted[end])
            assert parsers.ardupilot_thermal_offset(w, sensor, axis, beyond, centre) == pytest.approx(wanted[end])


@rows("reference", [-5.0, 35.0, 60.0])
def test_the_standard_errors_are_those_of_the_shifted_powers(reference):
    one = regression(centre=33.0)
    c, errors = polynomial(one, 4, reference)
    powers = [np.poly1d([1.0, reference - 33.0]) ** k for k in (1, 2, 3)]
    shift = np.array([np.pad(power.c[::-1], (0, 4 - power.c.size)) for power in powers]).T
    np.testing.assert_allclose(c[:4], shift @ one.mixture.values[:3], rtol=1e-12)
    np.testing.assert_allclose(errors[:4] ** 2, shift**2 @ one.mixture.errors[:3] ** 2, rtol=1e-12)
    assert c[4] == errors[4] == 0


def test_the_names_are_those_of_the_autopilots():
    both = study(regression(), regression(SIGNALS[1], "az"))
    text = al.exporting.temperature_parameters(both, "px4", instance=2).text
    parts = ["TMIN", "TMAX", "TREF", *(f"X{k}_{axis}" for k in range(4) for axis in range(3))]
    wanted = [f"TC_{s}2_{part}" for s in "GA" for part in parts]
    assert list(values(text, "\t")) == ["TC_G_ENABLE", "TC_A_ENABLE", *wanted]
    assert "\n1\t1\tTC_G_ENABLE\t1\t6\n" in text
    coefficients = [f"{s}{k}_{axis}" for s in ("GYR", "ACC") for k in (1, 2, 3) for axis in "XYZ"]
    for instance, prefix in {None: "INS_TCAL1_", 3: "INS_TCAL3_", 4: "INS4_TCAL_"}.items():
        found = values(al.exporting.temperature_parameters(both, "ardupilot", instance=instance).text, ",")
        assert list(found) == [prefix + part for part in ("ENABLE", "TMIN", "TMAX", *coefficients)]
        assert max(map(len, found)) <= 16  # what MAVLink takes


def test_what_shows_no_effect_is_zero_and_said():
    some = study(regression(), regression(name="gy", share=0), unfit=["gz"])
    found = al.exporting.temperature_parameters(some, "px4")
    v = values(found.text, "\t")
    assert v["TC_G0_X1_0"] != 0
    assert {v[f"TC_G0_X{k}_{axis}"] for k in range(4) for axis in (1, 2)} == {0.0}
    assert not any(name.startswith("TC_A") for name in v)
    assert "gy: no effect is shown" in found.notes[0]
    assert [str(alert) for alert in found.alerts] == ["gz is left out: it moves"]
    assert "# warning: gz is left out: it moves" in found.text
    # of ArduPilot both sensors share the range: without a record the other one is not corrected
    w = values(al.exporting.temperature_parameters(some, "ardupilot").text, ",")
    assert {value for name, value in w.items() if "_ACC" in name} == {0.0}


def test_axes_are_found_by_name_or_place():
    for names in (("w_z", "w_x", "w_y"), ("rate[2]", "rate[0]", "rate[1]")):
        made = [regression(name=name, centre=30.0 + i) for i, name in enumerate(names)]
        found = al.exporting.temperature_parameters(study(*made), "ardupilot")
        channels = {e.name[-1]: e.channels for e in found.entries if "GYR1" in e.name}
        wanted = dict(zip("ZXY" if names[0] == "w_z" else "XYZ", names, strict=True))
        assert channels == {axis: (name,) for axis, name in wanted.items()}


@rows("target", ["px4", "ardupilot"])
@rows("fits, error, words", [
    ([regression(powers=(1, 2, 3, 4, 5))], al.UsageError, r"powers up to 3, not 5: degree=3"),
    ([regression(powers=(1,), lag=60.0)], al.UsageError, "not temp, 60 s before as well"),
    ([regression(powers=(1,), smooth=60.0)], al.UsageError, "not d temp/dt as well"),
    ([regression(unit="K")], al.UsageError, "takes temperatures in degC, and 'temp' is in 'K'"),
    ([regression(span=None)], al.DataError, "lacks the range of 'temp': fit again"),
    ([regression(share=0)], al.DataError, "no effect of the temperature is shown for gx"),
    ([regression(name="rate")], al.UsageError, r"which axes rate are is not known.*Recipe\(channels"),
    ([regression(name="imu0_x"), regression(name="imu1_x")], al.UsageError, "which axes"),
])  # fmt: skip
def test_what_an_autopilot_does_not_take_is_refused(fits, error, words, target):
    refused(error, words, lambda: al.exporting.temperature_parameters(study(*fits), target))


def test_a_narrow_range_is_said():
    found = al.exporting.temperature_parameters(study(regression(span=(39.0, 42.5))), "px4")
    assert "changes by 3.5 degC only" in found.alerts[0]
