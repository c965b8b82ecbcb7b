"""The records that stand in for those of the papers, which publish none: commands, and files of columns."""

import numpy as np

import allanite as al

ANGLE = "N 0.004743 arcmin*sqrt(s), R 0.008333 arcmin/s, GM 0.02 arcmin 2 s"
FOG = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h), R 5 deg/h^2"
BEFORE = "Q 0.963036 arcsec, N 2.525648 deg/sqrt(h), B 12.023988 deg/h, K 32.72457 deg/h/sqrt(h), R 38.789995 deg/h^2"
AFTER = "Q 0.916159 arcsec, N 2.365199 deg/sqrt(h), B 3.235266 deg/h, K 10.682979 deg/h/sqrt(h), R 23.970946 deg/h^2"
ERRORS = "--error h:128=3,-1.5 --error h:256=1,2 --error q:128=-2,1 --error q:256=1.5,1"

COMMANDS = (
    f"simulate run1.csv --model '{ANGLE}' --unit arcmin --rate 10 --duration '60 min'",
    f"simulate run2.csv --model '{ANGLE}' --unit arcmin --rate 10 --duration '30 min' --seed 3",
    "simulate drift.npz --channels azimuth --model 'N 0.3 arcsec*sqrt(s), K 0.3 arcsec/sqrt(s), R -0.5 arcsec/s' "
    "--unit arcsec --rate 10 --duration '60 min'",
    "simulate white.npz --model 'N 1 deg/sqrt(h)' --rate 1 --samples 7200",
    "simulate biased.npz --model 'N 1 deg/sqrt(h)' --rate 1 --samples 7200 --constant '1000 deg/h'",
    "simulate walk.npz --model 'K 1 deg/h/sqrt(h)' --rate 1 --samples 7200",
    "simulate loop.npz --model 'N 0.01 deg/sqrt(h), GM2 1 deg/h 0.3 Hz 0.15' --rate 10 --duration '20 min'",
    f"simulate fog.npz --model '{FOG}' --rate 1 --duration '2 h'",
    "simulate step.npz --model 'N 1 deg/sqrt(h)' --rate 1 --duration '2 h' --noise-profile '0:1, 3599:1, 3600:3'",
    f"angle simulate hour.csv --latitude 60 --duration 3600 --q-law linear --start 7200 {ERRORS}",
    "simulate gl1.npz --sensor gl1 --constant '12.4392 deg/h' --rate 400 --duration '40 min'",
    "simulate smooth.npz --sensor gl1-smooth --constant '12.4392 deg/h' --rate 400 --duration '40 min'",
    "simulate turned1.npz --sensor gl1 --constant '2.8921 deg/h' --rate 400 --duration '10 min'",
    "simulate turned2.npz --sensor gl1 --constant '-2.8921 deg/h' --rate 400 --duration '10 min' --seed 2",
    f"simulate before.npz --model '{BEFORE}' --rate 1000 --duration 60",
    f"simulate after.npz --model '{AFTER}' --rate 1000 --duration 60 --seed 2",
    "simulate line.npz --model 'N 0.1 deg/sqrt(h), Sine 5 deg/h 0.02 Hz' --rate 10 --duration '20 min'",
    "simulate clean.npz --model 'N 0.1 deg/sqrt(h)' --rate 10 --duration '20 min' --seed 2",
    "simulate volts.npz --model 'N 1e-3 V*sqrt(s)' --unit V --rate 100 --duration 60",
    "simulate coil.npz --model 'N 3.6735e-3 A*sqrt(s)' --unit A --rate 1000 --duration 60",
    "simulate quiet.npz --model 'N 1e-9 deg/sqrt(h)' --rate 400 --duration '4 min' --constant '12.4392 deg/h' "
    "--quantize 'angle 0.0819875 arcsec'",
    "simulate brief.npz --model 'N 1 deg/sqrt(h)' --rate 1 --samples 1200",
    "simulate bump.npz --model 'N 1 deg/sqrt(h)' --rate 1 --samples 1200 --channels 60 --noise-profile "
    "'0:1, 300:1, 600:3, 900:1'",
    "simulate warmed.csv --model 'N 1 deg/sqrt(h), B 5 deg/h' --rate 1 --duration '1 h' --effect 'disp 1 um 300 s 40 "
    "deg/h' --effect 'temp 2 degC 1100 s 40 deg/h'",
    f"simulate fogs.npz --model '{FOG}' --rate 1 --duration '2 h' --channels 8",
)


def _columns(name, header, *columns):
    np.savetxt(name, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.15g")


def resolver(name):
    """Sine and cosine of the angle of the second run."""
    angle = np.radians(al.read("run2.csv").records[0].values / 60)
    _columns(name, "time [s],az_sin,az_cos", np.arange(angle.size) / 10, np.sin(angle), np.cos(angle))


def encoder(name):
    """An angle that errs by 20 urad sin 128 h + 10 urad cos 256 h, and a reference with noise of 1 urad."""
    angle = np.linspace(0, 6, 2000)
    measured = angle + 2e-5 * np.sin(128 * angle) + 1e-5 * np.cos(256 * angle)
    reference = angle + 1e-6 * np.random.default_rng(1).standard_normal(2000)
    _columns(name, "measured [rad],reference [rad]", measured, reference)


def currents(name):
    """Currents of two torquers of 0.2 rad/s per A, with cross-coupling of 1 %, at rates with noise of 1 mrad/s."""
    rates = np.radians([[1.0], [-2.0]]) + 1e-3 * np.random.default_rng(1).standard_normal((2, 60_000))
    x, y = np.linalg.solve([[0.01, -1.0], [1.0, 0.01]], rates) / 0.2
    _columns(name, "time [s],ix [A],iy [A]", np.arange(x.size) / 1000, x, y)


WRITTEN = {"resolver.csv": resolver, "encoder.csv": encoder, "currents.csv": currents}
"""Files that have more than noise in their columns."""
