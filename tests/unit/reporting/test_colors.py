"""Colours of the terms: distinct to every eye, and readable as text."""

from itertools import combinations, product

import numpy as np
import pytest
from tests.rows import rows

from allanite.reporting import style
from allanite.terms import TERMS

VISIONS = {
    "normal": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
"""Linear RGB as seen; Machado, Oliveira and Fernandes 2009, severity 1."""

XYZ = np.array([
    [0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041],
])  # fmt: skip
DISTINCT = 15.0  # least CIE 1976 colour difference of two lines
READABLE = 4.5  # least contrast of text, WCAG 2.1 AA

PAPER = {"light": "#FFFFFF", "dark": style.DARK["#ffffff"]}  # color of the ground


def linear(color):
    srgb = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def lab(color, vision):
    seen = np.clip(np.asarray(VISIONS[vision]) @ linear(color), 0, 1)
    t = XYZ @ seen / XYZ.sum(axis=1)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(one, other):
    low, high = sorted(float(XYZ[1] @ linear(color)) for color in (one, other))
    return (high + 0.05) / (low + 0.05)


def shown(ground):
    """Colours of the terms and of the data on a light or a dark ground."""
    data = style.DATA if ground == "light" else style.DARK[style.DATA.lower()]
    return {"data": data} | {s: row.color if ground == "light" else row.dark for s, row in TERMS.items()}


def difference(one, other, vision):
    return np.linalg.norm(lab(one, vision) - lab(other, vision))


def free(ground, symbol):
    """Colours that could be that of a term: those farthest from the others, and readable."""
    others = [color for name, color in shown(ground).items() if name != symbol]
    steps = [f"{level:02X}" for level in range(0, 256, 51)]
    could = [f"#{''.join(rgb)}" for rgb in product(steps, repeat=3)]
    could = [color for color in could if contrast(color, PAPER[ground]) >= READABLE]
    far = {color: min(difference(color, o, vision) for o in others for vision in VISIONS) for color in could}
    return sorted((color for color in far if far[color] >= DISTINCT), key=far.get)[:-4:-1]


@rows("vision", VISIONS)
@rows("ground", ["light", "dark"])
def test_no_two_lines_have_the_same_colour_to_any_eye(ground, vision):
    for (one, a), (other, b) in combinations(shown(ground).items(), 2):
        assert difference(a, b, vision) >= DISTINCT, (one, other, f"free colors: {', '.join(free(ground, other))}")


def test_the_colours_can_be_read_as_text():
    """Every colour of a figure has one for a dark ground."""
    for color in (style.INK, style.DATA, style.OTHER, style.FAIR, style.ALARM, *(row.color for row in TERMS.values())):
        assert contrast(color, PAPER["light"]) >= READABLE, color
        assert contrast(style.DARK[color.lower()], PAPER["dark"]) >= READABLE, color
    assert all(style.DARK[row.color.lower()].lower() == row.dark.lower() for row in TERMS.values())


def test_dashes_and_the_difference_of_the_standard():
    assert len({row.dash for row in TERMS.values()}) == len(TERMS)
    # red and green of sRGB: L*a*b* (53.24, 80.09, 67.20) and (87.74, -86.18, 83.18), difference 170.57
    assert np.linalg.norm(lab("#FF0000", "normal") - lab("#00FF00", "normal")) == pytest.approx(170.57, abs=0.05)
    assert contrast("#000000", "#FFFFFF") == pytest.approx(21)
