"""Records with known truth: noise of a model, faults of a channel, a ring laser gyro, a gimbal."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
