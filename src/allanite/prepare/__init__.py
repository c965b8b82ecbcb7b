"""Checks of a record before it is analyzed, and corrections of it."""

from allanite.core.correction import Correction as Correction

from .quality import inspect as inspect

from .transform import (  # isort: skip
    block_means as block_means, decimate as decimate, detrend as detrend, mark_outliers as mark_outliers
)  # fmt: skip
from .window import quiet_window as quiet_window, trim as trim
