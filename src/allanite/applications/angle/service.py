"""The sensors in service: constants whose samples come one after the other, in a memory that does not grow."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from allanite.extending import DataError, FloatArray

from .calibration import Calibration, Prior, examined, prior_of
from .geometry import ANGLES, Gimbals
from .harmonics import USUAL, Orders, design, harmonic_set
from .solve import CHECKPOINTS, ROBUST, History, Solution, System, checks, gate, omission, within_gate
from .squareroot import SquareRoot, batch

KEPT = 1 << 16  # last samples that are tested for what the model lacks
SCALED = 64  # innovations from which their spread is known
LATEST = 1024  # innovations that give it
LOST = 32  # outliers in succession from which they are none: the constants have changed
FIRST = 8  # samples for each constant that are taken in at first, together
UNKNOWN = 1.0  # rad, and rad/s: what is known of a constant before the first sample
UNIT = math.pi / 648_000  # rad: the noise of a sample until it is known


class Service:
    """A Kalman filter without prediction of the harmonics of a gimbal's sensors; see `estimate`."""

    def __init__(
        self, orders: Orders = (128, 256), nuisance: Sequence[str] = USUAL, sigma: float | None = None,
        prior: Prior | None = None,
    ) -> None:  # fmt: skip
        self.harmonics: Mapping[str, tuple[int, ...]] = harmonic_set(orders)
        self.nuisance, self.sigma, self.unit = tuple(nuisance), sigma, sigma or UNIT
        count = 2 * sum(map(len, self.harmonics.values())) + len(self.nuisance)
        self.prior = prior_of(prior, self.harmonics, count)
        self.known = SquareRoot.before(np.full(count, UNKNOWN) if self.prior is None else self.prior)
        self.recent, self.history = np.empty((len(ANGLES) + 4, 0)), list[tuple[int, float, FloatArray, FloatArray]]()
        self.omitted, self.row, self.first, self.last, self.stride = 0, 0, 0.0, -math.inf, 1
        self.heading, self.turning = 0.0, False
        self.waiting: list[tuple[FloatArray, FloatArray]] = []  # the first samples, which are gated together

    @property
    def count(self) -> int:
        """Samples that are taken in, or are to be with the first ones."""
        return self.known.count + sum(len(rows) for rows, _ in self.waiting)

    def add(self, z: FloatArray, gimbals: Gimbals) -> None:
        """Take in samples; those that are not later than the last one are passed over."""
        new = gimbals.time > self.last
        if not new.any():
            return
        self.heading, self.turning = gimbals.ring_heading, gimbals.rho is not None
        _, rows = design(gimbals, self.harmonics, self.nuisance, still=True)
        turn = np.zeros(z.size) if gimbals.rho is None else gimbals.rho
        kept = np.array([z, gimbals.time, turn, *(getattr(gimbals, name) for name in ANGLES), z])[:, new]
        self.last = float(gimbals.time[-1])
        self.waiting.append((rows[new] / self.unit, kept))
        if self.known.count or self.count >= FIRST * rows.shape[1]:
            self._take()

    def _take(self) -> None:
        rows, kept = np.vstack([rows for rows, _ in self.waiting]), np.hstack([kept for _, kept in self.waiting])
        self.waiting = []
        if not self.known.count:
            z = kept[0] / self.unit
            inside = within_gate(System((), rows, z, kept[1]), batch(rows, z), None if self.sigma is None else 1.0)
            self._omit(kept[1, ~inside])
            rows, kept = rows[inside], kept[:, inside]
        self._absorb(rows, kept)

    def _omit(self, time: FloatArray) -> None:
        self.first = float(time[0]) if time.size and not self.omitted else self.first
        self.omitted += time.size

    def _absorb(self, rows: FloatArray, kept: FloatArray) -> None:
        """Samples whose innovations are within the gate; of others, one half after the other."""
        known, innovations = self.known.absorb(rows, kept[0] / self.unit)
        early = 2 * rows.shape[1] if self.known.count < KEPT else 0  # nothing is expected of these yet
        late, count = np.abs(self.recent[-1, early:][-LATEST:]), kept.shape[1]
        spread = ROBUST * float(np.median(late)) if late.size >= SCALED else math.inf
        if np.abs(innovations).max() <= gate(max(LATEST, self.known.count)) * max(spread, self.sigma is not None):
            pass
        elif count > 1:
            half = count // 2
            self._absorb(rows[:half], kept[:, :half])
            self._absorb(rows[half:], kept[:, half:])
            return
        elif self.row < LOST:
            self._omit(kept[1])
            self.row += 1
            return
        self.known, self.row = known, 0
        self.recent = np.hstack([self.recent, np.vstack([kept[:-1], innovations])])[:, -KEPT:]
        if known.count >= self.stride * (len(self.history) + 1) and known.count > known.factor.shape[0]:
            self.history.append((known.count, float(kept[1, -1]), known.values, known.errors))
            if len(self.history) == 2 * CHECKPOINTS:
                self.history, self.stride = self.history[1::2], 2 * self.stride

    def result(self) -> Calibration:
        """The estimate so far, with what the last samples say against it."""
        p = self.known.factor.shape[0]
        if self.waiting and self.count > p + 2:
            self._take()
        n = self.known.count
        if n <= p or not self.history:
            raise DataError(f"{self.count} samples are too few for {p} constants and their noise; record for longer")
        z, time, turn, *angles = self.recent[:-1]
        rho = turn if self.turning else None
        gimbals = Gimbals(time, **dict(zip(ANGLES, angles, strict=True)), rho=rho, ring_heading=self.heading)
        names, rows = design(gimbals, self.harmonics, self.nuisance)
        ratio = math.sqrt(self.known.squares / (n - p)) if self.sigma is None else 1.0
        known = SquareRoot(self.known.factor / ratio, self.known.squares / ratio**2, n)
        counts, times, values, errors = (np.array(part) for part in zip(*self.history, strict=True))
        innovations = self.recent[-1] / ratio
        solution = Solution(names=names, values=known.values, covariance=known.covariance, sigma=ratio * self.unit,
                            given=self.sigma is not None, freedom=math.inf if self.sigma is not None else n - p,
                            condition=known.condition, prior=self.prior,
                            history=History(counts, times, values, ratio * errors), innovations=innovations,
                            known=known, checks=checks(innovations, known.squares, n - p, given=self.sigma is not None),
                            findings=omission(np.full(self.omitted, self.first), n + self.omitted,
                                              gate(max(LATEST, n))))  # fmt: skip
        return examined(solution, rows, z, gimbals, self.harmonics)
