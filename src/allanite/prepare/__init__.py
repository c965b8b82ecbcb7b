"""Checks of a record before it is analyzed, and corrections of it."""

from allanite.core.correction import Correction as Correction

from .quality import inspect as inspect
from .transform import block_means as block_means
from .transform import decimate as decimate
from .transform import detrend as detrend
from .transform import mark_outliers as mark_outliers
from .window import quiet_window as quiet_window
from .window import trim as trim
