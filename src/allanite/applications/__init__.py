"""Applications: special jobs of laboratories, which use what lies below through its public names only.

A rate measured with a laser gyro, angle sensors of gimbals, gyro-verticals, stages of a signal path, compensation of
temperature effects.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["angle", "attitude", "compensation",
                                                                         "constant_rate", "signals"])  # fmt: skip
