"""A target of export: its fields, and the way back from its file to the coefficients."""

import math
import tempfile
from pathlib import Path

from allanite.core.aliases import public
from allanite.core.constructors import K, N
from allanite.core.units import signal_named, unit_of
from allanite.exporting.export import export
from allanite.exporting.exports import EXPORTS
from allanite.exporting.imported import read_noise
from allanite.exporting.target import Target
from allanite.terms import TERMS

COEFFICIENTS = {"gyro": (2e-4, 3e-6), "accelerometer": (6e-3, 1.2e-4)}
"""N and K of each sensor, SI, within the ranges that autopilots accept."""

RATE = 123.0


@public
def check_target(target: Target) -> None:
    """Check the fields of a target, and that its file is read back to the coefficients it was made of.

    Raises
    ------
    AssertionError
        A unit does not fit its formula, a name is there twice, or the way back leads elsewhere: ``target 'mine': the
        unit rad/s of gyro_noise is not that of N``.

    Examples
    --------
    >>> from allanite import EXPORTS
    >>> check_target(EXPORTS["kalibr"])
    """
    about = f"target {target.name!r}:"
    assert len(target.source) > 20, f"{about} its source says too little"
    assert target.forms, f"{about} it has no form of a file"
    assert all(suffix.startswith(".") for suffix in target.forms), f"{about} a form is no suffix: {[*target.forms]}"
    names = [field.full for field in target.fields]
    assert len(set(names)) == len(names), f"{about} fields have the same name: {names}"
    time = unit_of("s").dimension
    for field in target.fields:
        power = TERMS[field.term].power if field.term else None
        own = (0.0,) * len(time) if power is None else unit_of(signal_named(field.sensor).si[power]).dimension
        inner = [o + t * (field.time - field.rate) / 2 for o, t in zip(own, time, strict=True)]
        fits = all(
            math.isclose(a, field.power * b, abs_tol=1e-12)
            for a, b in zip(unit_of(field.unit).dimension, inner, strict=True)
        )
        assert fits, f"{about} the unit {field.unit} of {field.full} is not that of {field.formula}"
    if target.fields:
        with EXPORTS.trying(target.name, target):
            _check_way_back(target, about)


def _check_way_back(target: Target, about: str) -> None:
    units = {"gyro": ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)"), "accelerometer": ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")}
    models = [N(n, units[sensor][0]) + K(k, units[sensor][1]) for sensor, (n, k) in COEFFICIENTS.items()]
    with tempfile.TemporaryDirectory() as folder:
        made = export(models, target.name, rate=RATE)
        path = Path(folder, f"file{made.suffix}")
        made.write(path)
        found = read_noise(path, target.name, rate=RATE)
    for sensor, sizes in COEFFICIENTS.items():
        fields = {field.term for field in target.fields if field.sensor == sensor}
        written = {symbol: size for symbol, size in zip("NK", sizes, strict=True) if symbol in fields}
        model = getattr(found, sensor) or ()
        values = {term.symbol: term.value for term in model}
        same = values.keys() == written.keys()
        same = same and all(math.isclose(values[symbol], size, rel_tol=1e-12) for symbol, size in written.items())
        assert same, f"{about} coefficients of the {sensor} are {written}, and read back as {values}"
