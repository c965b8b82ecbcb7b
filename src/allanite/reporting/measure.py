"""The size of texts in figures, which are the same in many of them."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath

Measure = Callable[[str, FontProperties, Any], tuple[float, float, float]]
"""Width, height and descent of a text, points."""


def measured(text: str, font: FontProperties, is_math: Any) -> tuple[float, float, float]:
    """The size of a text in an svg; remembered, as the figures of a page have many words in common."""
    return _measured(text, font.copy(), is_math)


@lru_cache(4096)
def _measured(text: str, font: FontProperties, is_math: Any) -> tuple[float, float, float]:
    width, height, descent = TextToPath().get_text_width_height_descent(text, font, is_math)
    return float(width), float(height), float(descent)
