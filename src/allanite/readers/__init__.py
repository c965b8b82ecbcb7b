"""Readers: one module per format, and the table that lists them.

A format is a module with ``TITLE`` and ``read(path, options) -> Recording``, and a line of `formats.registry.READERS`,
which says how its files are recognized. Most readers fill a `FileTable`, which identifies channels, units and rate;
containers of several tables or arrays use `containers` to decide which of them are meant. A format that is written has
``write(recording, path)`` and a line of `WRITERS`. Other packages register readers, which have a ``sniff(head, suffix)
-> bool`` as well, with the entry point group ``allanite.readers``.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from allanite.core.aliases import public
from allanite.core.errors import AllaniteError, DataError
from allanite.core.record import Record, Recording

from .options import FrameLike


@public
def read(  # noqa: PLR0913  a keyword for each thing that a file may not say
    path: str | os.PathLike[str] | FrameLike,
    *,
    rate: float | None = None,
    unit: str | Mapping[str, str] | None = None,
    kind: str | None = None,
    scale: float | str | None = None,
    channels: str | Sequence[str] | None = None,
    along: str | Sequence[str] | None = None,
    time: str | None = None,
    dtype: str | None = None,
    columns: int | None = None,
    offset: int | None = None,
    sincos: str | Sequence[str] | None = None,
    otherwise: str | Sequence[str] = (),
    progress: Callable[[float], None] | None = None,
) -> Recording:
    r"""Read a recording; its ``notes`` list the assumptions.

    Parameters
    ----------
    path : str, path or table
        The file, whose format is detected from its first bytes; .zip, .gz, .bz2 and .xz are unpacked, and
        ``"runs.zip::gyro.csv"`` names a member of an archive. ``"-"`` is standard input. Or a table of pandas, polars
        or pyarrow with column names like those of a CSV file: ``"gx [deg/s]"``.
    rate : float, optional
        Sampling rate, Hz; overrides the file, but for time stamps that give another one: see `time`.
    unit : str or dict, optional
        Unit of the samples, for example ``"deg/s"``; overrides headers, except for columns that belong to the
        other type of sensor according to their header or name and are not selected by `channels`. By sensor or by
        column: ``{"gyro": "deg/s", "accel": "g"}``, ``{"wx": "deg/s", "4": "g"}`` or ``"gyro=deg/s,accel=g"``.
    kind : {"rate", "increment", "angle", "count", "value"}, optional
        What a sample represents, if the unit does not determine it.
    scale : float or str, optional
        Scale factor per count, in `unit`; ``"0.01deg/s"`` gives both.
    channels : sequence of str, optional
        Names of columns, or their positions in the file counted from 1; by default all inertial signals.
    along : sequence of str, optional
        Columns of any kind to read in addition, placed after the signals: temperatures,
        currents. The unit is that of the header; without one they are plain numbers.
    time : str, optional
        The column of time stamps, as ``"stamp"``, ``"1"`` or ``"stamp[us]"``; ``"none"`` ignores time stamps.
    dtype : str, optional
        The file is raw binary of this type, written as in NumPy: ``"i2"``, ``">i2"`` (high byte first), ``"f4"``, or
        ``"u4,6i2"`` for rows of mixed types; or ``"kfgins"``. Raw binary is never guessed.
    columns, offset : int, optional
        Numbers per row of raw binary, and bytes before the first row.
    sincos : sequence of str, optional
        Columns of the sine and cosine of an angle, as a resolver gives them, in pairs: their unwrapped angle in rad is
        the channel, of kind "value", or "angle" if `kind` says so.
    otherwise : sequence of str, optional
        Names of signals, such as "current": where no column is that of an inertial sensor, those with a unit of these
        signals are read.
    progress : callable, optional
        Called with the share of the file that has been read, by formats that read it in a process of its own.

    Returns
    -------
    Recording
        With `source`, the sha256 `digest` of the file, `notes`, and `findings` about its clock. Integers stay integers;
        empty cells are NaN, and so are samples missing according to the time stamps or a counter.

    Raises
    ------
    DataError
        The file cannot be read, or its time stamps are not increasing and no rate is given.
    UsageError
        The rate, unit or kind is neither in the file nor given; a column does not exist; an argument is impossible.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name, "gyro.csv")
    >>> _ = path.write_text("time [s],gx [deg/s]\n0.00,1.5\n0.01,1.25\n0.02,1.75\n")
    >>> recording = read(path)
    >>> recording["gx"].rate, recording["gx"].unit, recording.notes[0]
    (100.0, 'deg/s', "rate 100.0 Hz from column 'time [s]'")
    >>> folder.cleanup()
    """
    from allanite.parallel.processes import later
    from allanite.readers.formats.registry import readable, reader_for, reader_of_type
    from allanite.readers.sandbox.packing import unpacked
    from allanite.readers.sandbox.source import digest_of, head_of, landed

    from .options import Options, channel_names, stated_unit

    options = Options(
        rate, channels=channel_names(channels), along=channel_names(along),
        unit=None if unit is None else stated_unit(unit), kind=kind, scale=scale, time=time, dtype=dtype,
        columns=columns, offset=offset, sincos=channel_names(sincos), otherwise=tuple(otherwise), progress=progress,
    )  # fmt: skip
    if not isinstance(path, (str, os.PathLike)) and hasattr(path, "columns"):
        from .formats import frame

        return frame.read(path, options)
    with landed(path) as (file, member, name):
        try:
            digest = later(lambda: digest_of(file))
            with unpacked(file, member, readable, only_by_suffix=dtype is not None) as inner:
                suffix = os.path.splitext(inner)[1].lower()
                reader = reader_of_type(options.dtype) if options.dtype else reader_for(head_of(inner), suffix)
                recording = reader.read(inner, options)
            return replace(recording, source=name, digest=digest.result())
        except AllaniteError as error:
            raise error.within(name) from None
        except OSError as error:
            why = f"the file cannot be read ({error.strerror or error}); check that it exists and that you may read it"
            raise DataError(f"{name}: {why}") from None
        except MemoryError:
            why = "the file does not fit into memory; read fewer channels, or a part of it"
            raise DataError(f"{name}: {why}") from None


@public
def write(recording: Recording | Record, path: str | os.PathLike[str], *, force: bool = False) -> None:
    r"""Write a recording so that `read` gives it back without options: values, rate, start, names, units, kinds.

    Parameters
    ----------
    recording : Recording or Record
        Channels of one rate, start and length.
    path : str or path
        The file; its suffix selects the format: .csv, .npz, .parquet, .h5, .hdf5 or .mat.
    force : bool
        Overwrite an existing file.

    Raises
    ------
    UsageError
        The suffix is not that of a format that can be written, the file exists, or its folder is not writable.
    DataError
        The channels differ in rate, start or length.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name, "gyro.csv")
    >>> write(Record([3, 1, 2], rate=100.0, unit="arcsec", kind="count", scale=0.1, name="gz"), path)
    >>> record = read(path)["gz"]
    >>> record.values.tolist(), record.rate, record.kind, record.scale, record.unit
    ([3, 1, 2], 100.0, 'count', 0.1, 'arcsec')
    >>> folder.cleanup()
    """
    from allanite.core.files import draft
    from allanite.readers.formats.registry import writer_for

    whole = Recording((recording,)) if isinstance(recording, Record) else recording
    first = whole[0]
    for record in whole:
        if (record.rate, record.start, len(record.values)) != (first.rate, first.start, len(first.values)):
            raise DataError(f"{record.name!r} ({record.rate} Hz, {len(record.values)} samples from {record.start} s) "
                            f"and {first.name!r} ({first.rate} Hz, {len(first.values)} samples from {first.start} s) "
                            "do not have the same sample times; write them to separate files")  # fmt: skip
    writer = writer_for(os.path.splitext(os.fspath(path))[1].lower())
    with draft(path, force=force) as part:
        writer.write(whole, str(part))
