"""Harmonic errors of a gimbal's angle sensors, from the measured cosine between two momentum vectors; findings."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from allanite.extending import (  # isort: skip
    POSITIVE, DataError, Finding, FloatArray, Value, demand_name, join, public, say, say_count)  # fmt: skip

from .geometry import Gimbals, column
from .harmonics import USUAL, Harmonics, Orders, amplitude_names, design, harmonic_set
from .latitude import contradiction
from .missing import missing
from .solve import Solution, System, correlation_of, solve
from .squareroot import SquareRoot

ALIKE = 0.9  # correlation above which two amplitudes are hardly distinguished
DISTURBED = 1.5  # growth of a standard error by the auto-compensating rotation above which it is reported
UNTOLD = 0.8  # standard error over the prior's, above which the samples say little
MAX_PHASE = 0.2  # phase shift of a harmonic by the error itself, rad, above which the linear model is doubtful

Prior = tuple[float, float]


def caveats(
    gimbals: Gimbals, harmonics: Mapping[str, tuple[int, ...]], names: tuple[str, ...], known: SquareRoot,
    prior: FloatArray | None,
) -> tuple[Finding, ...]:  # fmt: skip
    """Findings about an experiment, performed or planned."""
    count = 2 * sum(map(len, harmonics.values()))
    errors, correlation = known.errors, correlation_of(known.covariance)
    findings = [*_short(gimbals, harmonics, names, correlation), *_alike(names[:count], correlation)]
    turning = [i for i, name in enumerate(names) if name in ("ax", "az")]
    if turning:
        growth = errors[:count] / known.without(turning).errors[:count]
        worst = int(growth.argmax())
        if growth[worst] > DISTURBED:
            increased = say("the auto-compensating rotation increases the standard error of {constant} by a factor of "
                            "{factor:.2g}", constant=names[worst], factor=float(growth[worst]))  # fmt: skip
            remedy = say("choose another period of the rotation, or another range of angles")
            findings.append(Finding("turn", increased, say("its period is near that of an error"), remedy))
    findings += _sparse(gimbals, harmonics)
    ratios = errors / (math.inf if prior is None else prior)
    little = [name for name, ratio in zip(names, ratios, strict=True) if ratio > UNTOLD and name[0] in "SC"]
    if little:
        untold = say("the samples carry little information about {constants}: their estimates depend mostly on the "
                     "prior", constants=", ".join(little))  # fmt: skip
        remedy = say("choose a longer interval or another range of angles")
        findings.append(Finding("untold", untold, say("their estimates are biased towards zero"), remedy))
    return tuple(findings)


def _short(
    gimbals: Gimbals, harmonics: Mapping[str, tuple[int, ...]], names: tuple[str, ...], correlation: FloatArray
) -> Iterator[Finding]:
    for angle, orders in harmonics.items():
        span, period = gimbals.span(angle), 2 * math.pi / min(orders)
        if span < period:
            mine = [i for i, name in enumerate(names) if name.endswith(f" {angle}")]
            others = np.abs(correlation[mine] - np.eye(len(names))[mine])
            i, j = np.unravel_index(int(others.argmax()), others.shape)
            yield Finding(
                "span", say("the angle {angle} moves by {span:.3g} deg, less than one period of its harmonic {order} "
                            "({period:.3g} deg)",
                            angle=angle, span=math.degrees(span), order=min(orders), period=math.degrees(period)),
                say("its harmonics can hardly be separated: {first} correlates with {second} by {correlation:+.3f}",
                    first=names[mine[i]], second=names[j], correlation=float(correlation[mine[i], j])),
                say("choose a longer interval, or a part of the day where the angle moves faster"),
            )  # fmt: skip


def _alike(names: tuple[str, ...], correlation: FloatArray) -> Iterator[Finding]:
    size = np.abs(np.triu(correlation[: len(names), : len(names)], 1))
    pairs = sorted(np.argwhere(size > ALIKE).tolist(), key=lambda ij: -size[ij[0], ij[1]])
    if pairs:
        worst = [say("{first} and {second} ({correlation:+.2f})", first=names[i], second=names[j],
                     correlation=float(correlation[i, j])) for i, j in pairs[:3]]  # fmt: skip
        shown = say("hardly separable: {pairs}", pairs=join(", ", worst))
        more = say_count(len(pairs) - 3, "{shown} and {count} more pair", "{shown} and {count} more pairs", shown=shown)
        yield Finding("alike", more if len(pairs) > 3 else shown,
                      say("their periods nearly coincide, so that their errors are large and correlated; their joint "
                          "effect is known better"),
                      say("choose a range of angles where the periods differ, a longer interval, or sway"))  # fmt: skip


def _sparse(gimbals: Gimbals, harmonics: Mapping[str, tuple[int, ...]]) -> Iterator[Finding]:
    step = np.diff(gimbals.time)
    for angle, orders in harmonics.items():
        moved = np.abs(np.diff(np.unwrap(getattr(gimbals, angle)))) * max(orders) / (2 * math.pi)
        worst = int(moved.argmax())
        if moved[worst] > 0.25:
            yield Finding("sparse", say("between two samples ({step:.4g} s) {angle} moves by up to {periods:.2g} "
                                        "periods of its harmonic {order}", step=float(step[worst]),
                                        angle=angle, periods=float(moved[worst]), order=max(orders)),
                          say("an error between the samples is not observed, and angle and cosine must be sampled at "
                              "the same instant"),
                          say("sample at least four times per period"))  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Value):
    """Harmonics of a gimbal's angle sensors, estimated in service.

    Attributes
    ----------
    harmonics : tuple of Harmonics
        One for each angle; each is a Correction of that sensor's record.
    solution : Solution
        All constants, their covariance and history, the tests of the residuals.
    gimbals : Gimbals
        The angles they were estimated at.
    true : tuple of Harmonics
        The true errors of the sensors, where the record was simulated; harmonics that it lacks are zero.
    """

    _also: ClassVar[tuple[str, ...]] = ("truth",)

    harmonics: tuple[Harmonics, ...]
    solution: Solution
    gimbals: Gimbals
    true: tuple[Harmonics, ...] = ()

    @property
    def truth(self) -> dict[str, float]:
        """True amplitudes by name of the constant, rad; empty if they are not known."""
        known = {h.name: dict(zip(h.orders, zip(h.sine, h.cosine, strict=True), strict=True)) for h in self.true}
        if not known:
            return {}
        pairs = [pair for h in self for k in h.orders for pair in known.get(h.name, {}).get(k, (0.0, 0.0))]
        return dict(zip(self.solution.names, map(float, pairs), strict=False))

    @property
    def angles(self) -> tuple[str, ...]:
        """Names of the angles."""
        return tuple(h.name for h in self.harmonics)

    def __getitem__(self, angle: str) -> Harmonics:
        demand_name("angle", angle, self.angles, where=" of this estimate")
        return self.harmonics[self.angles.index(angle)]

    def __iter__(self) -> Iterator[Harmonics]:
        return iter(self.harmonics)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows of all harmonics, rad."""
        tables = [h.rows(level) for h in self.harmonics]
        return tables[0][0], [row for _, rows in tables for row in rows]

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        """The value written by `to_dict`; the solution, stored once, belongs to each angle."""
        result = super()._stored(data)
        return replace(result, harmonics=tuple(replace(h, solution=result.solution) for h in result.harmonics))

    def _summary(self) -> str:
        return "; ".join(f"{h.name}: {h.what}" for h in self.harmonics)


Result = Harmonics | Calibration  # what is estimated


def parts_of(result: Result) -> tuple[Harmonics, ...]:
    """The harmonics of each angle."""
    return result.harmonics if isinstance(result, Calibration) else (result,)


@public
def estimate(
    difference: ArrayLike, gimbals: Gimbals, *, orders: Orders = (128, 256), nuisance: Sequence[str] = USUAL,
    sigma: Annotated[float | None, POSITIVE] = None, prior: Prior | None = None, method: str = "recursive",
) -> Calibration:  # fmt: skip
    """Estimate the harmonics of the angle sensors while the earth's rotation, or a ship's sway, moves the gimbals.

    The measured cosine of the angle between the momentum vectors less the computed one is ``z = sum of f_a e_a(a)``,
    with the partial derivative f_a of the cosine and the harmonic error e_a of each angle a, plus the auto-compensation
    errors ax, az, the drift ``A1 sin(W t) + A2 cos(W t) + A3 t`` and white noise.

    Parameters
    ----------
    difference : array, shape (n,)
        Measured minus computed cosine. If yours is computed minus measured, change its sign.
    gimbals : Gimbals
        The angles as read, at the same instants.
    orders : sequence of int, or mapping of angle to such
        Harmonics; by default 128 and 256 of h and q of the equatorial gyro.
    nuisance : sequence of str
        Parameters estimated jointly: keys of `design.NUISANCES`. The default has no constant.
    sigma : float, optional
        Standard deviation of a sample's white noise, rad; by default it is estimated.
    prior : (amplitudes, rest), optional
        Prior standard deviations about 0, rad (rad/s for A3). None: no prior.
    method : {"recursive", "batch"}
        See `solve.solve`.

    Raises
    ------
    DataError
        Samples are not finite or too few, an angle does not move, or the samples do not separate the constants.
    UsageError
        A choice is impossible.

    Examples
    --------
    >>> from allanite import angle
    >>> one, two = ({128: (3e-6, 0.0)}, {256: (0.0, -2e-6)})
    >>> true = {"h": angle.Harmonics.of(one), "q": angle.Harmonics.of(two)}
    >>> hour = angle.gimbals(np.arange(7200.0, 10800.0, 10.0), latitude=np.radians(60))
    >>> z = angle.simulate(hour, true, sigma=1e-6, rng=np.random.default_rng(1))
    >>> found = estimate(z, hour)
    >>> found["h"].orders, bool(abs(found["h"].sine[0] - 3e-6) < 3 * found.solution.error("S128 h"))
    ((128, 256), True)
    """
    harmonics = harmonic_set(orders)
    z = column("the difference of cosines", difference, gimbals.time.size)
    if (largest := np.abs(z).max()) > 2:
        raise DataError(f"the difference of two cosines must be within 2, but is {largest:.4g}; is it scaled?")
    names, rows = design(gimbals, harmonics, nuisance)
    before = prior_of(prior, harmonics, len(names))
    solution = solve(System(names, rows, z, gimbals.time), sigma=sigma, prior=before, method=method)
    return examined(solution, rows, z, gimbals, harmonics)


def examined(
    solution: Solution, rows: FloatArray, z: FloatArray, gimbals: Gimbals, harmonics: Mapping[str, tuple[int, ...]]
) -> Calibration:
    """The harmonics of a solution, with what the samples say against it."""
    slopes = gimbals.partials
    sensors = {angle: (getattr(gimbals, angle), slopes[angle]) for angle in harmonics}
    findings = (*missing(solution, rows, z, sensors, harmonics), *contradiction(gimbals), *solution.findings,
                *caveats(gimbals, harmonics, solution.names, solution.known, solution.prior),
                *too_large(tuple(_parts(solution, harmonics))))  # fmt: skip
    solution = replace(solution, findings=findings)
    return Calibration(tuple(_parts(solution, harmonics)), solution, gimbals)


def prior_of(prior: Prior | None, harmonics: Mapping[str, tuple[int, ...]], size: int) -> FloatArray | None:
    """Standard deviations of `size` constants, of which the first are amplitudes of the harmonics."""
    if prior is None:
        return None
    amplitudes, rest = POSITIVE.demand(prior, "prior standard deviations")
    count = len(amplitude_names(harmonics))
    return np.array([amplitudes] * count + [rest] * (size - count))


def _parts(solution: Solution, harmonics: Mapping[str, tuple[int, ...]]) -> Iterator[Harmonics]:
    first = 0
    for angle, orders in harmonics.items():
        yield part(solution, angle, orders, first)
        first += 2 * len(orders)


def part(solution: Solution, angle: str, orders: tuple[int, ...], first: int) -> Harmonics:
    """The harmonics of one angle, whose constants begin at `first`."""
    mine = slice(first, first + 2 * len(orders))
    sine, cosine = solution.values[mine].reshape(-1, 2).T
    covariance = solution.covariance[mine, mine]
    return Harmonics(orders, sine.copy(), cosine.copy(), covariance, solution.freedom, angle, solution)


def too_large(harmonics: Sequence[Harmonics]) -> Iterator[Finding]:
    """Amplitudes that are not small relative to the period of their harmonic."""
    for h in harmonics:
        phase = h.amplitude * np.array(h.orders)
        worst = int(phase.argmax())
        if phase[worst] > MAX_PHASE:
            yield Finding("large",
                          say("harmonic {order} of {angle} shifts its own phase by {shift:.2g} rad",
                              order=h.orders[worst], angle=h.name or say("the angle"), shift=float(phase[worst])),
                          say("the linear model is doubtful for errors that are not small relative to their period"),
                          say("check units; correct the angles by this estimate, and estimate again"))  # fmt: skip
