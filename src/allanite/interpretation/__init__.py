"""What coefficients mean: sentences about a result, grades of sensors, and tables of likely causes by device."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
