"""What happens to a simulated record before it becomes a file: each a function from a record to a record.

They compose in any order that makes sense; each leaves a line in the history, and those that are random draw from the
generator that they are given.
"""

from .channel import clip as clip
from .channel import constant as constant
from .channel import gaps as gaps
from .channel import low_pass as low_pass
from .channel import noise_step as noise_step
from .channel import outliers as outliers
from .quantizers import Dither as Dither
from .quantizers import quantize_angle as quantize_angle
from .quantizers import quantize_rate as quantize_rate
