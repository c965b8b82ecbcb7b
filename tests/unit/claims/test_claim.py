"""What a text, a file or a name claims, and the factors that explain why a record misses it."""

import math

import pytest
from tests.rows import paired, refused, rows

import allanite as al
from allanite.claims.claim import claim_of, settings_in
from allanite.claims.convention import CONVENTIONS, NAN, Place, explaining, pooled
from allanite.exporting.exports import EXPORTS

GYRO = al.Model("N 1 deg/sqrt(h), K 30 deg/h/sqrt(h)")
ACCELEROMETER = al.Model("N 200 ug/sqrt(Hz), K 90 ug/sqrt(h)")


@rows("named, target", paired([False, True], [name for name, row in EXPORTS.items() if row.fields]))
def test_file_of_every_target_is_recognized(target, named, tmp_path):
    path = tmp_path / f"noise{next(iter(EXPORTS[target].forms))}"
    al.export([GYRO, ACCELEROMETER], target, rate=100.0, unexplained=True).write(path)
    found = claim_of(path, target if named else "", rate=100.0)
    assert found.kind == target or not named
    for model, wanted in zip(found.models, (GYRO, ACCELEROMETER), strict=True):
        for term in model:
            assert term.value == pytest.approx(wanted[term.symbol].value, rel=1e-5)
    assert not found.bound
    assert found.of(GYRO.signal) is found.models[0]


@rows("text, models", [
    ("0.3 deg/sqrt(h); 60 ug/sqrt(Hz); 3 ug", ["N = 0.3 deg/sqrt(h)", "N = 0.0353 m/s/sqrt(h), B = 3 ug"]),
    ("GM 3 deg/h 20 s, N 1 deg/sqrt(h)", ["GM = 3 deg/h with time constant 20 s, N = 1 deg/sqrt(h)"]),
])  # fmt: skip
def test_text_is_a_model(text, models):
    found = claim_of(text)
    assert ([str(model) for model in found.models], found.bound, found.kind) == (models, False, "model")


@rows("text, settings, rest", [
    ("lowpass 42 Hz", [("cutoff", 42.0, "")], ""),
    ("imu.yaml, Low-pass at 42 Hz; odr 1kHz", [("cutoff", 42.0, ""), ("rate", 1000.0, "")], "imu.yaml"),
    ("gyro dlpf 42 Hz, accelerometer bandwidth: 20.5 Hz", [("cutoff", 42.0, "gyro"), ("cutoff", 20.5, "accel")], ""),
    ("N 1 deg/sqrt(h), cut-off 9 Hz; 60 ug/sqrt(Hz)", [("cutoff", 9.0, "")], "N 1 deg/sqrt(h); 60 ug/sqrt(Hz)"),
    ("output rate 100 Hz; N 1 deg/sqrt(h)", [("rate", 100.0, "")], "N 1 deg/sqrt(h)"),
    ("N 1 deg/sqrt(h)", [], "N 1 deg/sqrt(h)"), ("rate.toml", [], "rate.toml"),
])  # fmt: skip
def test_settings_are_taken_out_of_a_text(text, settings, rest):
    found, left = settings_in(text)
    assert ([(s.quantity, s.value, s.sensor) for s in found], left) == (settings, rest)


def test_a_claim_with_settings_is_read_from_its_own_text():
    claim = claim_of("N 1 deg/sqrt(h); lowpass 42 Hz; 60 ug/sqrt(Hz), gyro rate 0.2 kHz")
    assert [s.words() for s in claim.settings] == ["lowpass 42 Hz", "gyro rate 200 Hz"]
    assert (len(claim.models), claim_of(claim.text)) == (2, claim)
    refused(al.UsageError, "a frequency must be between 1e-09 and 1e.15 Hz, not 0", lambda: claim_of("lowpass 0 Hz"))


def test_correlation_time_makes_a_gauss_markov_bias(tmp_path):
    values = {"NoiseDensity": "1e-4", "RandomWalk": "2e-5", "BiasCorrelationTime": "1000"}
    text = "".join(f"<gyroscope{name}>{value}</gyroscope{name}>" for name, value in values.items())
    (tmp_path / "imu.sdf").write_text(text)
    (model,) = claim_of(tmp_path / "imu.sdf").models
    assert (model["N"].value, model["GM"].value) == (pytest.approx(1e-4), pytest.approx(2e-5 * math.sqrt(500)))
    assert model["GM"].shape == (1000.0,)


def test_limits_are_bounds(tmp_path):
    file = tmp_path / "limits.toml"
    file.write_text('[limits]\nN = { max = "0.3 deg/sqrt(h)" }\n')
    found = claim_of(file)
    assert (found.kind, found.bound) == ("limits", True)
    assert [limit.symbol for limit in found.limits_of("gx", GYRO.signal)] == ["N"]
    assert not found.limits_of("ax", ACCELEROMETER.signal)


@rows("content, origin, kind, words", [
    ("arw: 0.2\nvrw: 0.1\n", "", al.UsageError, "navego or kf-gins|kf-gins or navego"),
    ("gyr_n: 0.01\nacc_n: 0.1\n", "", al.UsageError, "sampling rate"),
    ("focal_length: 400\n", "", al.DataError, "no field of a known target"),
    ("gyr_n: 0\n", "vins-mono", al.UsageError, "sampling rate"),
    ("gyroscope_noise_density: 0\n", "", al.DataError, "claims no noise"),
    ("gyr_n: 0.01\n", "kalbir", al.UsageError, "did you mean kalibr"),
])  # fmt: skip
def test_a_file_that_says_nothing_is_refused(content, origin, kind, words, tmp_path):
    (tmp_path / "imu.yaml").write_text(content)
    refused(kind, words, lambda: claim_of(tmp_path / "imu.yaml", origin))


@rows("name", ["adis16470", "ADIS 16470", "adis16470 gyro"])
def test_data_sheets_are_bounds(name):
    found = claim_of(name)
    assert (found.kind, found.bound, len(found.models)) == ("data sheet", True, 1 if "gyro" in name else 2)
    assert found.models[0]["N"].to("deg/sqrt(h)") == pytest.approx(0.34)


@rows("text, kind, words", [
    ("imu.yaml", al.DataError, "'imu.yaml' cannot be read: no such file"),
    ("limits.toml", al.UsageError, "limits.toml' cannot be read: no such file"),
    ("adis16740", al.UsageError, "did you mean the data sheet ADIS16470"),
    ("nothing", al.UsageError, "is no file, no data sheet, and no model .* lists the data sheets"),
    ("", al.UsageError, "no data sheet"), ("N 3", al.UsageError, "must be followed by a number and a unit"),
    ("3 parsec", al.UsageError, "unknown unit"),
])  # fmt: skip
def test_what_is_no_claim_is_refused(text, kind, words):
    refused(kind, f"(?i){words}", lambda: claim_of(text))


def place(row, **more):
    symbol = row.symbols[0] if row.symbols else "N"
    return Place(symbol, **{"claimed": 2.3e-4, "rate": 128.0, "time": 300.0, "other": 4.1e-3, "uniform": True} | more)


@rows("inverse", [False, True])
@rows("row", CONVENTIONS, ids=lambda row: f"{row.name} {row.symbols[:1]}")
def test_a_convention_is_named_where_its_factor_lies_in_narrow_limits_and_nowhere_else(row, inverse):
    where = place(row)
    factor = row.factor(where)
    if inverse:
        factor = 1 / factor if row.inverse else 1.37 * factor
    low, high = sorted((0.995 * factor, 1.005 * factor))
    found = [one for _, one in explaining(low, high, where)]
    assert (row in found) == (not inverse or row.inverse)
    assert len(found) <= 1 or row.name in ("57.3", "60")
    assert not explaining(0.99, 1.01, where)


@rows("row", CONVENTIONS, ids=lambda row: f"{row.name} {row.symbols[:1]}")
def test_what_is_not_known_explains_nothing(row):
    unknown = place(row, claimed=NAN, rate=NAN, time=NAN, other=NAN, uniform=False)
    factor = row.factor(unknown)
    wide = [one for _, one in explaining(1e-12, 1e12, unknown)]
    assert math.isnan(factor) == (row not in wide) or factor < 0


def test_several_are_ordered_by_their_distance():
    assert [name for name, _ in explaining(9, 11, Place("N", 1e-4, 100.0))] == ["sqrt(rate)", "9.81"]
    assert [name for name, _ in explaining(50, 66, Place("N", 1e-4, 9.0))] == ["57.3", "60"]


@rows("limits, low, high", [
    ([(1.2, 1.6)], 1.2, 1.6), ([(1, 4)] * 4, 2 / math.sqrt(2), 2 * math.sqrt(2)), ([(0, 2), (1, 3)], 1, 2),
    ([(1, math.inf), (2, 3)], 2, 3), ([(1, 2), (3, 4)], 3, 2),
])  # fmt: skip
def test_limits_of_axes_are_pooled_by_their_widths(limits, low, high):
    assert pooled(limits) == pytest.approx((low, high))
