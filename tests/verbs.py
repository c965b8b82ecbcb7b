"""Every verb, with arguments that show what it does: a row each, over the files of `furnish` and those of the examples.

A verb without a row is named where this module is imported. What reads the rows: stories/test_first_screen.py,
test_schema.py and test_languages.py, conformance/test_one_loop.py.
"""

import shlex
from typing import NamedTuple

import numpy as np
from click.testing import CliRunner

import allanite as al
from allanite.cli import VERBS, main
from allanite.exporting.exports import EXPORTS
from tests import ROOT

NOISE = '"N 0.1 deg/sqrt(h), K 10 deg/h/sqrt(h)"'
GIVEN = "--model 'N 0.3 deg/sqrt(h), K 10 deg/h/sqrt(h)' --model 'N 100 ug/sqrt(Hz), K 50 ug/sqrt(h)'"
BOTH = "--gyro 'N 0.3 deg/sqrt(h), B 10 deg/h' --accelerometer 'N 100 ug/sqrt(Hz), B 50 ug'"
TORQUER = "turns=100,field=0.4,span=0.05,radius=0.05,inertia=2e-3,spin=1000,sides=4"
SAMPLE = "tactical_gyro.csv"
TWO = f"{SAMPLE} --channels gx,gy"
SIX = ("ax [g]", "ay [g]", "az [g]", "gx [deg/s]", "gy [deg/s]", "gz [deg/s]")


class Row(NamedTuple):
    """What is tried of a verb.

    `runs` are arguments that show most of what it can say. `options` are those it needs beside a recording of a gyro
    and a thermometer, None if it reads no such recording. `screens` are commands in the folder of the examples, and
    what the first five lines of their answer have; the first is looked at most often. `others` are the same in the
    folder of `furnish`.
    """

    runs: tuple[str, ...] = ()
    options: str | None = None
    screens: dict[str, str] = {}  # noqa: RUF012 - never changed
    others: dict[str, str] = {}  # noqa: RUF012


ROWS = {
    "info": Row(
        ("a.csv", "short.csv", "wild.csv"),
        "",
        {f"info {SAMPLE}": r"fit for analysis\n.*\n.*\n *mean +°/h +4\.2"},
    ),
    "analyze": Row(
        ("a.csv --channels gx --device fog --about operator=x", "wild.csv --channels gx,gy,gz",
         "a.csv --channels gx --method slopes", "a.csv b.csv --channels gx --limits limits.toml",
         "a.csv b.csv --channels gx --device fog"),
        "",
        {f"analyze {SAMPLE}": r"N +angle random walk +°/√h +0\.1193 ± 1\.4 % +0\.1495"},
        {"analyze unit0.csv unit1.csv": r"2 of 2 units analyzed\n\nfile +channel +N °/√h .*\nunit0\.csv +gx +\d"},
    ),
    "batch": Row(),  # shows nothing
    "lot": Row(
        ("pair", "lot", "lot --limits limits.toml"),
        others={"lot pair": r"2 of 2 units analyzed\n\nfile +channel +N °/√h .*\nunit0\.csv +gx +\d"},
    ),
    "deviation": Row(
        ("a.csv --channels gx --statistic oadev,hdev,mtie", ),
        "",
        {f"deviation {TWO}": r"\n +0\.1 +22\.70 \(22\.50 \.\. 22\.90\) +28\.36",
         f"deviation --model {NOISE} --rate 10 --duration 1h": r"tau \[s\]",
         f"deviation {SAMPLE} {SAMPLE} --channels gx": r"\n +0\.1 +22\.70 \(22\.50 \.\. 22\.90\) +22\.70",
         f"deviation --model {NOISE} --model 'N 1 deg/sqrt(h)' --rate 10": r"\n2  N = 1 °/√h"},
    ),
    "spectrum": Row(
        ("a.csv --channels gx", "a.csv --channels gx --fit"),
        "--fit",
        {f"spectrum {TWO}": r"spectral density in °/h/√Hz"},
    ),
    "dynamic": Row(
        ("a.csv --channels gx", ),
        "--window 100",
        {f"dynamic {TWO}": r"\n +0\.1 +22\.\d+ to 23\.\d+"},
    ),
    "compare": Row(
        ("a.csv b.csv --channels gx", "a.csv b.csv wild.csv --channels gx", "a.csv --channels gx --part 60",
         "a.csv --channels gx --datasheet adis16470"),
        "--part 300",
        {f"compare {TWO}": r"changed: gx / gy\n\n.*\n +noise as a whole +changed, p < 1e-12",
         f"compare {TWO} --datasheet adis16470": r"Angular Random Walk +°/√h +0\.34 +0\.1193 ± 1\.4 %"},
    ),
    "check": Row(
        ("a.csv --channels gx --claims 'N 1 deg/sqrt(h), K 9000 deg/h/sqrt(h)' --at-most",
         "six.csv --claims 'N 0.3 deg/sqrt(h), K 20 deg/h/sqrt(h); 60 ug/sqrt(Hz)'",
         "a.csv --channels gx --claims limits.toml", "six.csv --claims adis16470",
         "a.csv --channels gx --claims 'N 1 deg/sqrt(h), GM 30 deg/h 20 s, R 3 deg/h^2'"),
        "--claims 'N 100 deg/sqrt(h)' --at-most",
        {f"check {TWO} --claims 'N 0.16 deg/sqrt(h), B 5 deg/h, K 60 deg/h/sqrt(h)' --at-most":
            r"agrees with the claim\n\n.*\nN +angle .* 0\.1600 +×0\.745"},
    ),
    "watch": Row(
        ("a.csv --channels gx", ),
        others={"watch a.csv --channels gx": r"a\.csv +gyroscope, 20 Hz"},
    ),
    "serve": Row(),  # until it is ended
    "rate": Row(
        ("a.csv --channels gx --interval 20", ),
        "--interval 60 --no-times --methods mean",
        {f"rate {TWO}": r"rate, mean over 1 h +°/h +4\.20 ± 0\.23 +-7\.90"},
    ),
    "angle": Row(
        ("calibrate encoder.csv --measured enc --reference ref",
         "estimate hour.csv --difference difference --latitude 60 --rho rho",
         "plan --latitude 60 --duration 3600", "plan --latitude 60 --duration 3600 --start 0"),
        screens={"angle plan --latitude 60 --duration 3600": r"The best window of 1 h begins"},
    ),
    "simulate": Row(
        ("made.csv --sensor mems --rate 20 --samples 2000 --force", ),
        others={"simulate walk.csv --model 'N 0.3 deg/sqrt(h)' --rate 10 --duration 100 --force":
                r"gx: gyroscope, rate in °/h, 10 Hz"},
    ),
    "plan": Row(
        ("--sensor fog --rate 10", "a.csv --channels gx"),
        "--unexplained",
        {f"plan --model {NOISE} --rate 10": r"N +0\.1 +°/√h .* 32 s\n",
         f"plan {TWO}": r"N +0\.1193 +°/√h .* 35 s\n",
         "plan --sensor mems --rate 100": r"\nN .* 3\.3 s\n",
         "plan --datasheet adis16470 --rate 100": r"\nN +0\.34 +°/√h"},
    ),
    "drift": Row(
        ("--sensor fog --require '1 deg in 10 min'", "six.csv --from-curve",
         f"{GIVEN} --times 3600 --turn-on '9 deg/h'", "a.csv --channels gx --calibration 0 --platform level"),
        "--unexplained",
        {f"drift {TWO}": r"\n10 s +0\.0123 +± 9\.\d %",
         f"drift --model {NOISE}": r"after +heading, attitude \[°\] +velocity \[m/s\] +position \[m\]\n1 s +0\.00",
         "drift --require '100 m in 1 min'": r"position after 60 s: 100 m required\n.*\naccelerometer +N +16\.90"},
    ),
    "selfcheck": Row(
        ("--sensor mems --rate 20 --samples 1000 --records 3", ),
        "--records 2 --unexplained",
        {"selfcheck --model 'N 0.1 deg/sqrt(h)' --rate 10 --duration 60 --records 4": r"truth +unit +bound"},
    ),
    "statespace": Row(
        ("--sensor fog --rate 10", ),
        "--unexplained",
        {f"statespace --model {NOISE} --rate 10": r"random walk", f"statespace {TWO}": r"Gauss-Markov rate"},
        {"statespace sway.csv --rate 10 --unexplained": r"\nax +1 +sinusoid"},
    ),
    "export": Row(
        ("six.csv --to vins-mono", "six.csv --to gazebo --axis each --inflate 2",
         "wild.csv six.csv --to kalibr --unexplained", "six.csv --to datasheet", f"--to px4 {GIVEN}",
         "six.csv --to statespace"),
        "--to datasheet --unexplained",
        {f"export {TWO} --model 'N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)' --to kalibr": r"gyroscope_noise_density +4\.3",
         f"export {TWO}": r"angle random walk N +°/√h +0\.119[23]"},
    ),
    "convert": Row(
        ("'1 deg/sqrt(h)' --to gtsam", "imu.yaml --from kalibr", "imu.yaml --from kalibr --to vins-mono",
         "--from px4 px4.params"),
        screens={'convert "0.66 deg/sqrt(h)"':
                    r"^0\.66 °/√h = 0\.011 °/s/√Hz = 39\.6 °/h/√Hz = 1\.92e-4 rad/s/√Hz \(two",
                 'convert "3 deg/h/sqrt(h)"': r"^3 °/h/√h = ",
                 f"convert {NOISE} --to kalibr": r"gyroscope_noise_density",
                 "convert adis16470": r"^0\.34 °/√h = 0\.005667 °/s/√Hz"},
    ),
    "explain": Row(
        ("", *EXPORTS, "px4-tc", "theo1", "hdev --samples 100", "theo1 --taus 9,75", "adis16470", "N", "weak"),
        screens={"explain": r"targets: kalibr, openvins", "explain oadev": r"How much means of the rate",
                 "explain ARW": r"N / √τ", "explain not-valid": r"does not explain the record",
                 "explain kalibr": r"gyroscope_noise_density",
                 "explain sch16t-k01": r"gyroscope: N = 0\.025 °/√h, B = 0\.3 °/h"},
    ),
    "example": Row(screens={"example": r"^000  stabilizer: angle error"}),  # runs the others
    "quantization": Row(
        (f"current.csv --unit V --stage 'ADC 12 5V' --torquer {TORQUER} --sense 5", ),
        "--stage 'output 16 300deg/s'",
        {f"quantization {TWO} --stage 'ADC 16 400deg/s'": r"ADC adds N = 0\.06686 .* 31 % of the measured variance"},
    ),
    "compensate": Row(
        ("a.csv --regressors temp --channels gx", "a.csv --regressors temp --to px4 -o a.params --force"),
        "--regressors {regressor}",
        others={"compensate a.csv --regressors temp": r"gx depends on temp"},
    ),
    "vertical": Row(
        ("six.csv", "six.csv --filter bortz", "six.csv --filter kalman --time-constant 5 --keep-bias",
         f"{BOTH} --gyro-bias '10 deg/h'", f"{BOTH} --scenarios --rate 10", "six.csv --gate 0.001"),
        screens={"vertical --gyro 'N 0.3 deg/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz)'":
                 r"time constant \S+ s: RMS error"},
    ),
}  # fmt: skip
ROWS = {verb: ROWS[verb] for verb in VERBS}


def run(line, *codes):
    """Run a command line, which may end with these codes, or 0."""
    done = CliRunner().invoke(main, shlex.split(line))
    assert done.exit_code in (0, *codes), (line, done.output)
    return done


def furnish(folder):
    """Write the small files that the rows name."""
    (folder / SAMPLE).symlink_to(ROOT / "examples" / SAMPLE)
    rng = np.random.default_rng(3)
    _recording(folder / "a.csv", 1)
    _recording(folder / "b.csv", 2)
    _recording(folder / "short.csv", 3, n=40)
    wild = {"gy [deg/h]": 90 * rng.standard_normal(2000).cumsum(), "gz [deg/h]": np.zeros(2000)}
    _recording(folder / "wild.csv", 4, **wild)
    _six(folder / "six.csv")
    sway = np.sin(np.arange(900) / 4)[:, None] + rng.normal(size=(900, 6))
    _table(folder / "sway.csv", dict(zip(SIX, sway.T, strict=True)))
    (folder / "limits.toml").write_text('[limits]\nN = { max = "0.01 deg/sqrt(h)" }\nB = { max = "90 deg/h" }\n')
    (folder / "px4.params").write_text("1\t1\tEKF2_GYR_NOISE\t0.015\t9\n")
    volts = np.round(rng.standard_normal(4000) * 100) * 0.01
    _table(folder / "current.csv", {"time [s]": np.arange(4000) / 1000, "ux [V]": volts})
    true = np.linspace(0, 12.5, 2000)
    measured = true + 1e-4 * np.sin(128 * true) + 1e-5 * rng.standard_normal(2000)
    _table(folder / "encoder.csv", {"enc [deg]": np.degrees(measured), "ref [deg]": np.degrees(true)})
    run("convert '1 deg/sqrt(h)' 'K 9 deg/h/sqrt(h)' '90 ug/sqrt(Hz)' 'K 10 ug/sqrt(h)' --to kalibr --rate 100 "
        f"-o '{folder}/imu.yaml'")  # fmt: skip
    run(f"angle simulate '{folder}/hour.csv' --latitude 60 --duration 3600 --start 7200 --error h:128=3,-1.5")
    _lot(folder)


def _table(path, columns):
    values = np.column_stack(list(columns.values()))
    np.savetxt(path, values, "%.10g", ",", header=",".join(columns), comments="")


def _recording(path, seed, n=2000, **more):
    """A gyroscope at 20 Hz."""
    rng = np.random.default_rng(seed)
    model = al.N(0.1, "deg/sqrt(h)") + al.K(20.0, "deg/h/sqrt(h)")
    rate = np.degrees(al.simulate(model, n, 20.0, rng=rng).values) * 3600
    temp = 25 + 5 * np.sin(np.arange(n) / 300) + 0.02 * rng.standard_normal(n)
    _table(path, {"time [s]": np.arange(n) / 20.0, "gx [deg/h]": rate + 3 * temp, "temp [degC]": temp, **more})


def _six(path, n=4000, rate=20.0):
    """Three gyros and three accelerometers at rest."""
    rng = np.random.default_rng(5)
    gyro = al.N(0.3, "deg/sqrt(h)") + al.K(300.0, "deg/h/sqrt(h)")
    gyros = {f"g{axis} [deg/s]": np.degrees(al.simulate(gyro, n, rate, rng=rng).values) for axis in "xyz"}
    noise = al.N(100, "ug/sqrt(Hz)")
    forces = {
        f"a{axis} [m/s^2]": up + al.simulate(noise, n, rate, rng=rng).values
        for axis, up in (("x", 0.0), ("y", 0.0), ("z", 9.80665))
    }
    _table(path, {"time [s]": np.arange(n) / rate, **gyros, **forces})


def _lot(folder):
    """Stored results of eight units, of which one is noisy and one too short, and of the first two."""
    lines = ["file,temperature,date"]
    for i, size in enumerate((0.1, 0.11, 0.12, 0.13, 0.14, 5.0)):
        record = al.simulate(al.N(size, "deg/sqrt(h)"), 2000, 20.0, rng=np.random.default_rng(i), name="gx")
        al.write(record, folder / f"unit{i}.csv")
        lines.append(f"unit{i}.csv,{20 + i},2024-05-{10 + i}")
    (folder / "units.csv").write_text("\n".join([*lines, "a.csv,,", "short.csv,,"]) + "\n")
    run(f"batch '{folder}/units.csv' --out '{folder}/lot' --workers 1 --channels gx", 5)
    (folder / "pair.csv").write_text("\n".join(lines[:3]) + "\n")
    run(f"batch '{folder}/pair.csv' --out '{folder}/pair' --workers 1 --channels gx")
