"""Faults of a simulated record: functions from a record to a record.

They can be combined in any order; each adds an entry to the history, and random ones use the generator passed to them.
"""

from .channel import (  # isort: skip
    Dither as Dither, clip as clip, constant as constant, gaps as gaps, low_pass as low_pass, noise_profile as
    noise_profile, outliers as outliers, quantize_angle as quantize_angle, quantize_rate as quantize_rate
)  # fmt: skip
