"""Which axes of the sensors are forward, sideways and vertical."""

from dataclasses import dataclass

import numpy as np

from allanite.extending import DataError, FloatArray, Record, UsageError, spelled

NAMES = "xyz"


@dataclass(frozen=True)
class Axes:
    """The axes of the file that are forward, sideways and vertical; right-handed.

    With the vertical axis up the second is to the left, with the vertical axis down to the right.

    Examples
    --------
    >>> Axes.of("y,-x,z")
    Axes(index=(1, 0, 2), sign=(1, -1, 1))
    >>> str(Axes.upright(np.array([0.1, -9.8, 0.2])))
    'x,z,-y'
    """

    index: tuple[int, ...] = (0, 1, 2)  # 0, 1 or 2 for x, y or z of the file
    sign: tuple[int, ...] = (1, 1, 1)  # -1 for an axis that points the other way

    @classmethod
    def of(cls, text: str) -> "Axes":
        """Read three names with signs."""
        parts = [part.strip().lower() for part in text.split(",")]
        index = [NAMES.find(part.lstrip("+-")) for part in parts]
        if sorted(index) != [0, 1, 2] or any(len(part) > 2 for part in parts):
            raise UsageError("the axes that are forward, sideways and vertical are x, y and z in some order, each with "
                             f"or without a minus, such as {_spelled('y,-x,z')}, not {text!r}")  # fmt: skip
        found = cls(tuple(index), tuple(-1 if part[0] == "-" else 1 for part in parts))
        if np.linalg.det(found.matrix) < 0:
            a, b, c = found.sign
            other = cls(found.index, (a, -b, c))
            raise UsageError(f"the axes {text} are left-handed: the second is to the left of the first if the third is "
                             f"up, and to the right if it is down; {_spelled(other)} is right-handed")  # fmt: skip
        return found

    @classmethod
    def upright(cls, force: FloatArray) -> "Axes":
        """Those with the largest mean specific force up, and forward along the first of the others."""
        up = int(np.abs(force).argmax())
        forward = 1 if up == 0 else 0
        vertical, ahead = np.sign(force[up]) * np.eye(3)[up], np.eye(3)[forward]
        left = np.cross(vertical, ahead)
        side = int(np.abs(left).argmax())
        return cls((forward, side, up), (1, int(left[side]), int(vertical[up])))

    def __str__(self) -> str:
        return ",".join(("-" if s < 0 else "") + NAMES[i] for i, s in zip(self.index, self.sign, strict=True))

    @property
    def matrix(self) -> FloatArray:
        """From the axes of the file to these, shape (3, 3)."""
        return np.asarray(np.eye(3)[list(self.index)] * np.array(self.sign)[:, None])

    def ordered(self, records: tuple[Record, ...]) -> tuple[Record, ...]:
        """The sensors that are forward, sideways and vertical; their samples keep their signs."""
        return tuple(records[i] for i in self.index)

    def turned(self, values: FloatArray) -> FloatArray:
        """Samples along the axes of the file, shape (n, 3), along these."""
        return np.asarray(values[:, list(self.index)] * np.array(self.sign, dtype=np.float64))


def demand_upright(force: FloatArray) -> None:
    """Refuse specific forces whose mean, shape (3,), is not mostly along z."""
    found = Axes.upright(force)
    if found.index[2] == 2:
        return
    up, size = str(found).split(",")[2], np.abs(force) / np.linalg.norm(force)
    raise DataError(
        f"gravity is along {up}, not z: {size.max():.0%} of the mean specific force; give {_spelled(found)}, the axes "
        f"that are forward, sideways and vertical (another one may be forward), or {_spelled('x,y,z')} if the body "
        "lies on its side"
    )


def _spelled(axes: Axes | str) -> str:
    """The option that gives these axes."""
    return spelled(f"--axes {axes}", f"axes='{axes}'")
