"""The first screen of every verb: at most 20 lines of 100 columns, with the answer in the first five."""

import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner
from tests import ROOT

from allanite.cli import VERBS, main

SAMPLE = shlex.quote(str(ROOT / "examples" / "tactical_gyro.csv"))
TWO = f"{SAMPLE} --channels gx,gy"
NOISE = '"N 0.1 deg/sqrt(h), K 10 deg/h/sqrt(h)"'
CLAIM = "N 0.16 deg/sqrt(h), B 5 deg/h, K 60 deg/h/sqrt(h)"

SCREENS = {
    f"analyze {SAMPLE}": r"N +angle random walk +°/√h +0\.1192 ± 1 % +0\.1495",
    f"info {SAMPLE}": r"fit for analysis\n.*\n.*\n *mean +°/h +4\.2",
    f"deviation {TWO}": r"\n +0\.1 +22\.70 \(22\.50 \.\. 22\.90\) +28\.36",
    f"deviation --model {NOISE} --rate 10 --duration 1h": r"tau \[s\]",
    f"deviation {SAMPLE} {SAMPLE} --channels gx": r"\n +0\.1 +22\.70 \(22\.50 \.\. 22\.90\) +22\.70",
    f"deviation --model {NOISE} --model 'N 1 deg/sqrt(h)' --rate 10": r"\n2  N = 1 °/√h",
    f"spectrum {TWO}": r"spectral density in °/h/√Hz",
    f"dynamic {TWO}": r"\n +0\.1 +22\.\d+ to 23\.\d+",
    f"compare {TWO}": r"changed: gx / gy\n\n.*\n +noise as a whole +changed, p < 1e-12",
    f"check {TWO} --claims {CLAIM!r} --at-most": r"agrees with the claim\n\n.*\nN +angle .* 0\.1600 +0\.745",
    f"rate {TWO}": r"rate, mean over 1 h +°/h +4\.20 ± 0\.23 +-7\.90",
    f"plan --model {NOISE} --rate 10": r"N +0\.1 +°/√h .* 20 s\n",
    f"plan {TWO}": r"N +0\.1192 +°/√h .* 20 s\n",
    "plan --sensor mems --rate 100": r"\nN .* \d+ s\n",
    f"drift --model {NOISE}": r"after +heading, attitude \[°\] +velocity \[m/s\] +position \[m\]\n1 s +0\.00",
    f"drift {TWO}": r"\n10 s +0\.0123 +± 10 %",
    "drift --require '100 m in 1 min'": r"position after 60 s: 100 m required\n.*\naccelerometer +N +16\.90",
    f"budget {TWO} --stage 'ADC 16 400deg/s'": r"ADC adds N = 0\.06686 .* 31 % of the measured variance",
    f"statespace {TWO}": r"Gauss-Markov rate",
    f"statespace --model {NOISE} --rate 10": r"random walk",
    f"export {TWO}": r"angle random walk N +°/√h +0\.1192",
    f"export {TWO} --model 'N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)' --to kalibr": r"gyroscope_noise_density +4\.3",
    'convert "0.66 deg/sqrt(h)"': r"^0\.66 °/√h = 0\.011 °/s/√Hz = 39\.6 °/h/√Hz = 1\.92e-4 rad/s/√Hz \(two",
    'convert "3 deg/h/sqrt(h)"': r"^3 °/h/√h = ",
    f"convert {NOISE} --to kalibr": r"gyroscope_noise_density",
    "explain": r"targets: kalibr, openvins",
    "explain oadev": r"degrees of freedom",
    "explain kalibr": r"gyroscope_noise_density",
    "explain sch16t-k01": r"gyroscope: N = 0\.025 °/√h, B = 0\.3 °/h",
    f"compare {TWO} --datasheet adis16470": r"Angular Random Walk +°/√h +0\.34 +0\.1192 ± 1 %",
    "plan --datasheet adis16470 --rate 100": r"\nN +0\.34 +°/√h",
    "convert adis16470": r"^0\.34 °/√h = 0\.005667 °/s/√Hz",
    "example": r"^000  angle error",
    "vertical --gyro 'N 0.3 deg/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz)'": r"time constant \S+ s: RMS error",
    "angle plan --latitude 60 --duration 3600": r"The best window of 1 h begins",
    "selfcheck --model 'N 0.1 deg/sqrt(h)' --rate 10 --duration 60 --records 4": r"truth +unit +bound",
}
"""Commands, and what of their answer the first five lines have."""


def printed(line):
    done = CliRunner().invoke(main, shlex.split(line))
    assert done.exit_code == 0, done.stderr
    return done.stdout


def bounded(text):
    lines = text.splitlines()
    assert len(lines) <= 20
    assert max(map(len, lines)) <= 100


@pytest.mark.parametrize("line", SCREENS)
def test_the_first_screen_is_short_and_begins_with_the_answer(line):
    text = printed(line)
    bounded(text)
    assert re.search(SCREENS[line], "\n".join(text.splitlines()[:5]) + "\n")
    assert not re.search(r"\de\+0\d", text)


MADE = {
    "analyze units/a.csv units/b.csv --rate 10": r"2 of 2 units analyzed\n\nfile +channel +N °/√h .*\na\.csv +gx +\d",
    "lot stored": r"2 of 2 units analyzed\n\nfile +channel +N °/√h .*\na\.csv +gx +\d",
    "simulate walk.csv --model 'N 0.3 deg/sqrt(h)' --rate 10 --duration 100": r"gx: gyroscope, rate in °/h, 10 Hz",
    "compensate warm.csv --rate 10 --regressors temp": r"gx depends on temp",
    "compensate both.csv --rate 10 --regressors temp --to px4 -o a.params": r"gx +gy\nvariance removed +\d.* no effect",
    "statespace six.csv --rate 10 --unexplained": r"\nax +1 +sinusoid",
    "watch warm.csv --channels gx --idle 0.2 --rate 10": r"warm\.csv +gyroscope, 10 Hz",
}
"""The same of verbs that need files of their own, in the folder of `made`."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two units, their stored results, and a gyro that follows a temperature."""
    folder, rng = tmp_path_factory.mktemp("made"), np.random.default_rng(1)
    (folder / "units").mkdir()
    for name in ("a", "b"):
        np.savetxt(folder / "units" / f"{name}.csv", rng.normal(size=2000), header="gx [deg/h]", comments="")
    temperature = 20 + 5 * np.sin(np.arange(2000) / 200)
    columns = np.column_stack([rng.normal(size=2000) + temperature, temperature])
    np.savetxt(folder / "warm.csv", columns, delimiter=",", header="gx [deg/h],temp [degC]", comments="")
    both = np.column_stack([columns[:, 0], rng.normal(size=2000), temperature])
    np.savetxt(folder / "both.csv", both, delimiter=",", header="gx [deg/h],gy [deg/h],temp [degC]", comments="")
    six = np.hstack([np.outer(np.sin(np.arange(900) / 4), np.ones(6)) + rng.normal(size=(900, 6))])
    names = "ax [g],ay [g],az [g],gx [deg/s],gy [deg/s],gz [deg/s]"
    np.savetxt(folder / "six.csv", six, delimiter=",", header=names, comments="")
    return folder


@pytest.mark.parametrize("line", MADE)
def test_the_first_screen_of_files_that_are_made(line, made, monkeypatch):
    monkeypatch.chdir(made)
    if line.startswith("lot"):
        printed("batch units --out stored --rate 10")
    text = printed(line)
    bounded(text)
    assert re.search(MADE[line], "\n".join(text.splitlines()[:5]) + "\n")


def test_every_verb_is_looked_at():
    assert {line.split()[0] for line in (*SCREENS, *MADE)} | {"batch", "serve"} == set(VERBS)
