"""Many units: the same analysis of many files, held against limits, with mean, spread and worst over all of them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
