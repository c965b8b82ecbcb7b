"""Noise analysis of gyroscopes and accelerometers from static recordings, with confidence intervals.

Names are imported when they are first used; ``__init__.pyi`` says where each of them is.
"""

from typing import Any

import lazy_loader

_named, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """What the stub names, or the constructor of a noise term that the table `TERMS` was given later."""
    try:
        return _named(name)
    except AttributeError:
        from .core.model import TERMS, constructor
        from .statistics import STATISTICS

        if name in STATISTICS:
            raise AttributeError(f"{name} is a statistic: type al.deviation(x, {name!r}, rate=100)") from None
        if name not in TERMS:
            raise
        return constructor(name)
