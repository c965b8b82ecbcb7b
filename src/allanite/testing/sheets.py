"""A data sheet: every line is one that can be found in its document, and makes a coefficient of its sensor."""

import math

from allanite.core.aliases import public
from allanite.core.errors import UnitError
from allanite.core.plain import from_dict
from allanite.core.units import signal_named, unit_of
from allanite.planning.datasheets import QUANTITIES, SENSORS, DataSheet

LIMITS = ("typical", "nominal", "maximum", "")


@public
def check_data_sheet(sheet: DataSheet) -> None:
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
    about = f"data sheet {sheet.name!r}:"
    assert sheet.name.strip() == sheet.name, f"{about} its name begins or ends with a space"
    assert sheet.name, f"{about} it has no name"
    assert sheet.maker, f"{about} it has no maker"
    assert len(sheet.document) > 5, f"{about} its document is not named"
    assert sheet.claims, f"{about} it has no lines"
    assert len(set(sheet.claims)) == len(sheet.claims), f"{about} a line is there twice"
    for claim in sheet.claims:
        line = f"{about} {claim.printed!r} in {claim.unit} of the {claim.sensor}:"
        assert claim.sensor in SENSORS, f"{line} the sensors are {', '.join(SENSORS)}"
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
    assert sheet.models, f"{about} no coefficient follows from its lines"
    assert from_dict(sheet.to_dict()) == sheet, f"{about} it is not the same when it is stored and read again"
