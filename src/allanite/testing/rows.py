"""What a plug-in adds, against itself: a reader, a statistic, a data sheet, a target of export, a verb."""

import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner

from allanite.cli import VERBS, main
from allanite.cli.front import DATA, Verb
from allanite.core.aliases import public
from allanite.core.errors import AllaniteError, UnitError, UsageError
from allanite.core.model import K, N
from allanite.core.plain import from_dict
from allanite.core.record import Record, Recording
from allanite.core.units import signal_named, unit_of
from allanite.exporting.export import export
from allanite.exporting.exports import EXPORTS
from allanite.exporting.imported import read_noise
from allanite.exporting.target import Target
from allanite.planning.datasheets import QUANTITIES, SENSOR_TYPES, DataSheet
from allanite.readers.formats.registry import PARTS, FormatReader
from allanite.readers.options import Options
from allanite.reporting import page
from allanite.simulation.record import simulate
from allanite.statistics import STATISTICS, deviation, expected
from allanite.statistics.row import Statistic
from allanite.terms import TERMS

from .checks import NONE, checking

LIMITS = ("typical", "nominal", "maximum", "")


@public
def check_data_sheet(sheet: DataSheet, *, expected_failed_checks: Mapping[str, str] = NONE) -> None:
    """Check the lines of a data sheet: words, units, places, and that a model follows from them.

    Raises
    ------
    AssertionError
        A line lacks its place, a unit is not that of its quantity, a line is there twice: ``data sheet 'X1': 'Noise
        Density' in deg/h of the gyro: 'deg/h' is not a unit of N``.

    Examples
    --------
    >>> from allanite import DATASHEETS
    >>> check_data_sheet(DATASHEETS["ADIS16470"])
    """
    with checking(f"data sheet {sheet.name!r}", expected_failed_checks) as check:
        with check("document"):
            assert sheet.name.strip() == sheet.name, "its name begins or ends with a space"
            assert sheet.name, "it has no name"
            assert sheet.maker, "it has no maker"
            assert len(sheet.document) > 5, "its document is not named"
        with check("lines"):
            assert sheet.claims, "it has no lines"
            assert len(set(sheet.claims)) == len(sheet.claims), "a line is there twice"
            for claim in sheet.claims:
                line = f"{claim.printed!r} in {claim.unit} of the {claim.sensor}:"
                assert claim.sensor in SENSOR_TYPES, f"{line} the sensors are {', '.join(SENSOR_TYPES)}"
                assert claim.quantity in QUANTITIES, f"{line} {claim.quantity!r} is none of {', '.join(QUANTITIES)}"
                assert claim.limit in LIMITS, f"{line} {claim.limit!r} is none of {LIMITS}"
                assert claim.printed, f"{line} it has no name"
                assert claim.place, f"{line} it has no page or table"
                assert 0 < claim.value < math.inf, f"{line} its value is {claim.value}"
                try:
                    term = claim.term
                except UnitError as error:
                    raise AssertionError(f"{line} {error}") from None
                if term is not None:
                    assert term.signal.name == claim.sensor, f"{line} its unit is that of the {term.signal.sensor}"
                else:
                    fits = unit_of(claim.unit).dimension == signal_named(claim.sensor).dimension
                    assert fits, f"{line} its unit is not that of the {claim.sensor}"
        with check("stored"):
            assert sheet.models, "no coefficient follows from its lines"
            assert from_dict(sheet.to_dict()) == sheet, "it is not the same when it is stored and read again"


SIZE = 240
FACTORS = (1, 2, 4, 8)
RECORDS = 60


@public
def check_statistic(row: Statistic, *, expected_failed_checks: Mapping[str, str] = NONE) -> None:
    """Check that a row of `STATISTICS` keeps what it says.

    It is described; windows fit up to its largest averaging factor; its sums are those of its windows, and 0 of a
    polynomial below its order; and its mean over simulated records is what is expected of white noise.

    Raises
    ------
    AssertionError
        It does not: ``statistic 'mydev': sums at m = 4 are 2.1, but those of its windows 1.05``.

    Examples
    --------
    >>> from allanite import STATISTICS
    >>> check_statistic(STATISTICS["hdev"])
    """
    with checking(f"statistic {row.name!r}", expected_failed_checks) as check:
        with check("texts"):
            for text in ("name", "title", "formula", "reference", "meaning", "use", "limits", "cost"):
                assert getattr(row, text), f"{text} is empty"
        if row.parts:
            return  # they have rows of their own
        most = row.largest(SIZE)
        m = np.array([factor * row.step for factor in FACTORS if factor * row.step <= most])
        whole = row.window is not None and row.span[0] > 0 and not row.extreme
        with check("factors"):
            assert most > 0, f"no averaging factor fits in {SIZE} intervals"
            assert np.all(row.count(SIZE, m) > 0), "no window fits at averaging factors up to the largest"
        with check("order"):
            line = np.arange(SIZE + 1.0) ** (row.order - 1)
            rest = np.abs(row.sums(line, m)) / (np.abs(line).max() ** 2 * row.count(SIZE, m))
            assert np.all(rest < 1e-12), f"order is {row.order}, but t^{row.order - 1} is not left out"
        with check("windows"):
            x = np.concatenate(([0.0], np.cumsum(np.random.default_rng(1).standard_normal(SIZE))))
            for factor, total in zip(m.tolist(), row.sums(x, m), strict=True) if whole else ():
                own = _by_windows(row, x, factor)
                words = f"sums at m = {factor} are {total:.12g}, but those of its windows {own:.12g}"
                assert np.isclose(total, own, rtol=1e-8), words
        with check("mean"):
            if whole and row.order > 1:  # others have no intervals
                _check_mean(row, m)


def _by_windows(row: Statistic, x: "np.ndarray[tuple[int], np.dtype[np.float64]]", m: int) -> float:
    """The sum of squares over the windows of x, as the row defines one."""
    assert row.window is not None
    weights, filters = row.window(m)
    every = np.lib.stride_tricks.sliding_window_view(x, filters.shape[1])[:: 1 if row.overlapped else m]
    of_each = (every @ filters.T) ** 2 @ weights
    return float(of_each[: int(row.count(x.size - 1, np.array([m]))[0])].sum())


def _check_mean(row: Statistic, m: "np.ndarray[tuple[int], np.dtype[np.int64]]") -> None:
    """Compare the mean over simulated records with the expectation."""
    with STATISTICS.trying(row.name, row):
        model, rng = N(1.0, "rad/sqrt(s)"), np.random.default_rng(2)
        records = [Record(simulate(model, SIZE, 1.0, rng=rng).values, 1.0, "rad/s") for _ in range(RECORDS)]
        curves = [deviation(record, row.name, m=m.tolist(), noise=model) for record in records]
        mean = np.mean([curve.variance for curve in curves], axis=0)
        exact = expected(model, row.name, curves[0].tau, rate=1.0, size=SIZE)
    off = (mean / exact - 1) / np.sqrt(2 / (np.array(curves[0].edf) * RECORDS))
    assert np.all(np.abs(off) < 5), (
        f"the mean over {RECORDS} records of white noise is {mean / exact} of what is expected, "
        f"{np.abs(off).max():.0f} standard errors away"
    )


COEFFICIENTS = {"gyro": (2e-4, 3e-6), "accelerometer": (6e-3, 1.2e-4)}
"""N and K of each sensor, SI, within the ranges that autopilots accept."""

FILE_RATE = 123.0


@public
def check_target(target: Target, *, expected_failed_checks: Mapping[str, str] = NONE) -> None:
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
    with checking(f"target {target.name!r}", expected_failed_checks) as check:
        with check("source"):
            assert len(target.source) > 20, "its source says too little"
            assert target.forms, "it has no form of a file"
            assert all(suffix.startswith(".") for suffix in target.forms), f"a form is no suffix: {[*target.forms]}"
        with check("fields"):
            names = [field.full for field in target.fields]
            assert len(set(names)) == len(names), f"fields have the same name: {names}"
            for field in target.fields:
                power = TERMS[field.term].power if field.term else None
                time = unit_of("s").dimension
                own = (0.0,) * len(time) if power is None else unit_of(signal_named(field.sensor).si[power]).dimension
                inner = [o + t * (field.time - field.rate) / 2 for o, t in zip(own, time, strict=True)]
                fits = all(math.isclose(a, field.power * b, abs_tol=1e-12)
                           for a, b in zip(unit_of(field.unit).dimension, inner, strict=True))  # fmt: skip
                assert fits, f"the unit {field.unit} of {field.full} is not that of {field.formula}"
        if target.fields:
            with check("way_back"), EXPORTS.trying(target.name, target):
                _check_way_back(target)


def _check_way_back(target: Target) -> None:
    units = {"gyro": ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)"), "accelerometer": ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")}
    models = [N(n, units[sensor][0]) + K(k, units[sensor][1]) for sensor, (n, k) in COEFFICIENTS.items()]
    with tempfile.TemporaryDirectory() as folder:
        made = export(models, target.name, rate=FILE_RATE)
        path = Path(folder, f"file{made.suffix}")
        made.write(path)
        noise = read_noise(path, target.name, rate=FILE_RATE)
    for sensor, sizes in COEFFICIENTS.items():
        fields = {field.term for field in target.fields if field.sensor == sensor}
        written = {symbol: size for symbol, size in zip("NK", sizes, strict=True) if symbol in fields}
        model = getattr(noise, sensor) or ()
        values = {term.symbol: term.value for term in model}
        same = values.keys() == written.keys()
        same = same and all(math.isclose(values[symbol], size, rel_tol=1e-12) for symbol, size in written.items())
        assert same, f"coefficients of the {sensor} are {written}, and read back as {values}"


ABSENT = "there is no such file.csv"


@public
def check_verb(verb: Verb, *arguments: str, expected_failed_checks: Mapping[str, str] = NONE) -> dict[str, Any]:
    """Check that a verb has a help, that its JSON is read again and shown, and that it refuses a file that is absent.

    Parameters
    ----------
    verb : Verb
        The row of `VERBS`.
    *arguments : str
        Of a run of it.
    expected_failed_checks : mapping of str to str
        Names of checks that are known to fail, each with the reason.

    Returns
    -------
    dict
        What it has written as JSON.

    Raises
    ------
    AssertionError
        It does not: ``verb 'extent': what is read of its JSON differs in low``.

    Examples
    --------
    >>> check_verb(VERBS["explain"], "vins-mono")["type"]
    'Explanation'
    """
    runner = CliRunner()
    with (
        VERBS.trying(verb.name, verb),
        tempfile.TemporaryDirectory() as folder,
        checking(f"verb {verb.name!r}", expected_failed_checks) as check,
    ):
        with check("help"):
            assert verb.group, "it has no heading of the help to stand below"
            assert verb.imported().get_short_help_str(), "it has no help"
            shown = runner.invoke(main, [verb.name, "--help"])
            assert shown.exit_code == 0, f"--help ends with {shown.exit_code}: {shown.output}"
        absent = [str(Path(folder, ABSENT)) if Path(word).is_file() else word for word in arguments]
        path = Path(folder, "result.json")
        done = runner.invoke(main, [verb.name, *arguments, "--json", str(path)])
        assert done.exit_code == 0, f"verb {verb.name!r}: it ends with {done.exit_code}: {done.output}"
        data: dict[str, Any] = json.loads(path.read_text("utf-8"))
        with check("stored"):
            again = from_dict(data).to_dict()
            lost = [key for key in data if key in again and again[key] != data[key]]
            assert not lost, f"what is read of its JSON differs in {', '.join(lost)}"
        with check("page"):
            try:
                page(from_dict(data))
            except UsageError as error:
                raise AssertionError(f"its result has no page: {error}") from error
        with check("absent"):
            if absent != [*arguments]:
                refused = runner.invoke(main, [verb.name, *absent])
                assert refused.exit_code in {2, DATA}, f"without its file it ends with {refused.exit_code}"
                assert "internal error" not in refused.output, refused.output
                assert ABSENT in " ".join(refused.output.split()), f"it does not name the file: {refused.output}"
    return data


@public
def check_reader(
    module: FormatReader,
    path: str | os.PathLike[str],
    *,
    expected_failed_checks: Mapping[str, str] = NONE,
    **choices: Any,
) -> None:
    r"""Check that a reader recognizes and reads a file, and says what is wrong with one that is cut off.

    Parameters
    ----------
    module : module or object
        With TITLE, sniff and read.
    path : path
        A file of the format.
    expected_failed_checks : mapping of str to str
        Names of checks that are known to fail, each with the reason.
    **choices
        What the file does not say: fields of `Options`, such as ``rate=100.0``.

    Raises
    ------
    AssertionError
        It does not: ``reader of 'tones of a recorder': cut off after 7 bytes, it raises ValueError() instead of a
        DataError``.

    Examples
    --------
    >>> from allanite.readers.formats import text
    >>> path = Path(tempfile.mkdtemp(), "gyro.csv")
    >>> size = path.write_text("gz [deg/s]\n" + "0.5\n0.25\n" * 20)
    >>> check_reader(text, path, rate=100.0)
    """
    file, title = Path(path), getattr(module, "TITLE", None)
    with checking(f"reader of {title!r}", expected_failed_checks) as check:
        with check("parts"):
            missing = [part for part, kind in PARTS.items() if not isinstance(getattr(module, part, None), kind)]
            assert not missing, f"it has no {', '.join(missing)}"
        data = file.read_bytes()
        with check("sniff"):
            known = "dtype" in choices or module.sniff(data[:4096], file.suffix)
            assert known, f"sniff does not recognize {file.name}"
        with check("channels"):
            recording = module.read(str(file), Options(**choices))
            assert isinstance(recording, Recording), f"read returns a {type(recording).__name__}, not a Recording"
            assert len(recording), "the recording has no channel"
            for record in recording:
                assert record.rate > 0, f"{record.name} has a sampling rate of {record.rate}"
                assert np.isfinite(record.values).any(), f"{record.name} has no finite sample"
        with check("cut_off"), tempfile.TemporaryDirectory() as folder:
            cut = Path(folder, f"cut{file.suffix}")
            for size in sorted({0, 1, 7, len(data) // 3, len(data) // 2, len(data) - 1}):
                cut.write_bytes(data[:size])
                try:
                    module.read(str(cut), Options(**choices))
                except AllaniteError as error:
                    if len(str(error)) < 10:
                        raise AssertionError(f"cut off after {size} bytes, it says {str(error)!r}") from error
                except Exception as error:
                    raise AssertionError(f"cut off after {size} bytes, it raises {error!r} instead of a "
                                         "DataError") from error  # fmt: skip
