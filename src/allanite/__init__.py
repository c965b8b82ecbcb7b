"""Noise analysis of gyroscopes and accelerometers from static recordings, with confidence intervals.

Names are imported when they are first used; ``__init__.pyi`` says where each of them is.
"""

from importlib import import_module
from typing import Any

import lazy_loader

_named, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

_ROOMS = {
    "applications.compensation": "Regression compensate_file CompensationSettings",
    "applications.constant_rate": "measure_rates",
    "applications.signals": "Budget Stage TorqueScale budget budget_file rate_from_current PathSettings",
    "batch": "Batch Lot Specification analyze_files run_batch read_lot",
    "claims": "ClaimedNoise ClaimCheck DriftSettings claim_of",
    "comparison": "Pool SheetComparison compare_with_sheet pool truncation",
    "exporting": "EXPORTS Imported temperature_parameters",
    "extending": "convert",
    "identification": "METHODS Residuals Shared",
    "interpretation": "DEVICES Meaning",
    "planning": "DATASHEETS SENSORS Bound DataSheet RecordingPlan SelfCheck data_sheet_named",
    "prepare": "Correction",
    "simulation": "GL1 RingLaser faults simulate_ring_laser",
    "statistics": "LongJobWarning STATISTICS Surface",
    "terms": "TERMS",
}
_MOVED = {name: room for room, names in _ROOMS.items() for name in names.split()}
"""Names that are understood here, and the package of each."""


def __getattr__(name: str) -> Any:
    """What the stub names, a name of one of the packages, or the constructor of a noise term of the table `TERMS`."""
    try:
        return _named(name)
    except AttributeError:
        if name.startswith("_"):
            raise
    if name in _MOVED:
        return getattr(import_module(f"{__name__}.{_MOVED[name]}"), name)
    from .core.model import TERMS, constructor

    if name in TERMS:
        return constructor(name)
    raise AttributeError(_meant(name), name=name, obj=import_module(__name__))


def _needed(function: Any) -> str:
    """The arguments that a function cannot do without."""
    from inspect import signature

    return ", ".join(p.name for p in signature(function).parameters.values() if p.default is p.empty and p.kind == 1)


def _meant(name: str) -> str:
    """The call that is meant by a name of other libraries, or by a synonym of a verb or a statistic."""
    from .cli import VERBS
    from .core.habits import CALLS, remedy
    from .core.names import unknown
    from .statistics import STATISTICS

    if call := remedy(CALLS, name):
        return f"allanite has no {name}: type {call}"
    for row in STATISTICS.values():
        if name == row.name or name in row.synonyms:
            return f"{name} is a statistic: type al.deviation(x, {row.name!r}, rate=100)"
    for verb in VERBS.values():
        if name in verb.synonyms and verb.name in __all__:
            return f"allanite has no {name}: type al.{verb.name}({_needed(_named(verb.name))})"
    error = unknown("name", name, __all__, listed=False)
    return str(error) if error.cure[1] else f"{error}; dir(allanite) lists the names that there are"
