"""Upper bounds read off the measured curve: where no model explains the record, and for terms that were struck out."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.commands import run
from tests.rows import rows

import allanite as al
from allanite.exporting.choice import BOUND, axes_of, bounded
from allanite.exporting.content import Axis
from allanite.exporting.export import prepared
from allanite.exporting.fields import How
from allanite.reporting import first_screen
from allanite.reporting.digits import digits

GYRO = al.Model("N 0.3 deg/sqrt(h), B 7 deg/h, K 30 deg/h/sqrt(h)")
ACCELEROMETER = al.Model("N 60 ug/sqrt(Hz), B 30 ug, K 200 ug/sqrt(h)")


def shaken(model, name, seed):
    """Noise that is three times as loud at last, which no model explains."""
    record = al.simulate(model, 20_000, 40.0, rng=np.random.default_rng(seed), name=name)
    return record.with_values(record.values * np.repeat([1.0, 3.0], record.size // 2), "shaken")


@pytest.fixture(scope="module")
def car():
    return al.Recording((shaken(GYRO, "gx", 1), shaken(ACCELEROMETER, "ax", 2)))


@pytest.fixture(scope="module")
def study(car):
    return al.analyze(car)


@pytest.fixture(scope="module")
def file(tmp_path_factory, study):
    """The result as it is stored: the limits of its curves are known for one level."""
    path = tmp_path_factory.mktemp("data") / "car.json"
    path.write_text(json.dumps(study.to_dict()))
    return str(path)


@pytest.mark.slow("takes more than half a second")
def test_the_refusal_names_what_writes_a_file(file, tmp_path):
    refused = run("export", file, "--to", "kalibr")
    assert (refused.exit_code, refused.stdout) == (3, "")
    assert refused.stderr.rstrip().endswith(
        "To use the coefficients nevertheless: --unexplained; for upper bounds: --from-curve"
    )
    forced = run("export", file, "--to", "kalibr", "--unexplained")
    assert forced.exit_code == 0 or "for upper bounds: --from-curve" in forced.stderr
    run("export", file, "--to", "kalibr", "--from-curve", "--cover=no", "-o", tmp_path / "imu.yaml", code=0)
    text = (tmp_path / "imu.yaml").read_text()
    assert text.count(f"{BOUND}, this is its 95 % upper limit") == 4
    assert "gx: upper bound read off the Allan deviation" in text
    assert "# rad/s/sqrt(Hz), N of gx: upper bound" in text


@pytest.mark.slow("seconds of analyses")
def test_bounds_are_those_of_the_curve_and_above_the_truth(study):
    found = al.export(study, "kalibr", from_curve=True, cover=False)
    for channel, sensor, truth in zip(study, ("gyroscope", "accelerometer"), (GYRO, ACCELEROMETER), strict=True):
        curve = channel.curve
        high = curve.interval(0.95)[1]
        at = int(np.abs(np.log(curve.tau)).argmin())
        late = curve.tau >= 1
        walk = (high / np.sqrt(curve.tau / 3))[late].min()
        assert found[f"{sensor}_noise_density"] == pytest.approx(high[at] * np.sqrt(curve.tau[at]), rel=1e-9)
        assert found[f"{sensor}_random_walk"] == pytest.approx(walk, rel=1e-9)
        assert found[f"{sensor}_noise_density"] > truth["N"].value
        assert found[f"{sensor}_random_walk"] > truth["K"].value
        (axis,) = (bounded(a, asked=True) for a in axes_of(channel))
        assert axis.fit["B"].upper == pytest.approx(high[late].min() / np.sqrt(2 * np.log(2) / np.pi), rel=1e-9)
    assert not any(entry.measured for entry in found.entries)


@pytest.mark.slow("seconds of analyses")
def test_the_first_screen_has_the_values_of_the_file(study):
    made = al.export(study, "kalibr", from_curve=True)
    (line,) = (line for line in first_screen(study).splitlines() if "--to kalibr" in line)
    gyro, accelerometer = (
        ", ".join(digits(made[f"{sensor}_{key}"], figures=3).plain()[0] for key in ("noise_density", "random_walk"))
        for sensor in ("gyroscope", "accelerometer")
    )
    assert line == f"kalibr, bounds: {gyro}; {accelerometer} (allanite export FILE --to kalibr --from-curve)"


@rows("target", sorted(set(al.exporting.EXPORTS) - {"kalibr"}))
def test_every_target_says_so(target, file):
    row, _ = prepared(target, How(), "")
    found = run("export", file, "--to", target, "--from-curve", "--json", "-", code=0)
    if not row.fields or all(field.term for field in row.fields):
        assert "upper bound read off the Allan deviation" in found.stdout


def test_a_struck_slow_term_has_an_upper_limit():
    """The best model lacked it, and so did the file: the worst axis was that of the others."""
    record = al.simulate(GYRO, 20_000, 40.0, rng=np.random.default_rng(3), name="gx")
    (channel,) = al.analyze(record)
    struck = replace(channel, noise=replace(channel.noise, fit=channel.noise.fit.invalid("the curve says less", "K")))
    found = al.export([struck, ACCELEROMETER], "kalibr", rate=40.0)
    entry = next(e for e in found.entries if e.name == "gyroscope_random_walk")
    assert entry.remark == f"{BOUND}, this is its 95 % upper limit"
    assert entry.values[0] > GYRO["K"].value
    assert next(e for e in found.entries if e.name == "gyroscope_noise_density").measured


def test_a_curve_is_needed():
    record = al.simulate(GYRO, 20_000, 40.0, rng=np.random.default_rng(3), name="gx")
    axis = Axis("gx", al.identify(record).invalid("any"), 40.0, "not explained")
    with pytest.raises(al.DataError, match=r"gx: there is no Allan deviation with intervals.*statistic='oadev'"):
        bounded(axis, asked=True)
