"""Readers: one format one file, and the table that lists them.

A format is a module with ``TITLE``, ``sniff(head, suffix) -> bool`` and ``read(path, options) -> Recording``, and a
line of `formats.READERS`. Most fill a `table.Table` and let it find channels, units and rate.
"""

import os
from collections.abc import Sequence
from dataclasses import replace

from allanite.errors import AllaniteError, DataError
from allanite.record import Recording


def read(
    path: str | os.PathLike[str],
    *,
    rate: float | None = None,
    unit: str | None = None,
    kind: str | None = None,
    scale: float | None = None,
    channels: Sequence[str] | None = None,
    time: str | None = None,
) -> Recording:
    r"""Read a recording; its ``notes`` say what was assumed.

    Parameters
    ----------
    path : str or path
        The file; its format is found from its first bytes.
    rate : float, optional
        Sampling rate, Hz; wins over what the file says.
    unit : str, optional
        Unit of the readings, for example ``"deg/s"``; wins over headers, except for columns that by their header or
        name belong to the other sensor and are not chosen in `channels`.
    kind : {"rate", "increment", "angle", "count"}, optional
        What a reading is, where the unit does not tell.
    scale : float, optional
        Worth of one step of the readings in `unit`.
    channels : sequence of str, optional
        Names of columns, or their places in the file counted from 1; all inertial signals if left out.
    time : str, optional
        The column of stamps, as ``"stamp"``, ``"1"`` or ``"stamp[us]"``; ``"none"`` ignores stamps.

    Returns
    -------
    Recording
        With `source`, the sha256 `digest` of the file, `notes`, and in `findings` what is wrong with its clock.
        Integers stay integers; an empty cell is NaN, and so is a reading that was lost by the stamps or a counter.

    Raises
    ------
    DataError
        The file cannot be read, or its stamps go back or jump so that they give no rate, and none is given.
    UsageError
        Rate, unit or kind is neither in the file nor given; a column does not exist; an option is impossible.

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
    from .formats import reader_for
    from .options import Options, channel_names
    from .source import checked, digest_of, head_of

    options = Options(rate, unit, kind, scale, channel_names(channels), time)
    name = checked(path)
    try:
        recording = reader_for(head_of(name), os.path.splitext(name)[1].lower()).read(name, options)
        return replace(recording, source=name, digest=digest_of(name))
    except AllaniteError as error:
        raise type(error)(f"{name}: {error}") from None
    except OSError as error:
        raise DataError(
            f"{name}: the file cannot be read ({error.strerror or error}); check that it is there and may be read"
        ) from None
    except MemoryError:
        raise DataError(f"{name}: the file does not fit into memory; read fewer channels, or a part of it") from None
