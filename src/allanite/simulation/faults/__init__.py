"""Faults of a simulated record: functions from a record to a record.

They can be combined in any order; each adds an entry to the history, and random ones use the generator passed to them.
"""

from .channel import Dither as Dither
from .channel import clip as clip
from .channel import constant as constant
from .channel import gaps as gaps
from .channel import low_pass as low_pass
from .channel import noise_profile as noise_profile
from .channel import outliers as outliers
from .channel import quantize_angle as quantize_angle
from .channel import quantize_rate as quantize_rate
