"""What can be learnt from a record of some length: bound, plan, check of the identification, typical sensors."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
