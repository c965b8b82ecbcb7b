"""Findings about an experiment: how well it separates its constants."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from allanite.extending import Finding, FloatArray, join, say, say_count

from .geometry import Gimbals
from .solve import correlation_of
from .squareroot import SquareRoot

ALIKE = 0.9  # correlation above which two amplitudes are hardly distinguished
DISTURBED = 1.5  # growth of a standard error by the auto-compensating rotation above which it is reported
UNTOLD = 0.8  # standard error over the prior's, above which the samples say little


def caveats(
    gimbals: Gimbals,
    harmonics: Mapping[str, tuple[int, ...]],
    names: tuple[str, ...],
    known: SquareRoot,
    prior: FloatArray | None,
) -> tuple[Finding, ...]:
    """Findings about an experiment, performed or planned."""
    count = 2 * sum(map(len, harmonics.values()))
    errors, correlation = known.errors, correlation_of(known.covariance)
    findings = [*_short(gimbals, harmonics, names, correlation), *_alike(names[:count], correlation)]
    turning = [i for i, name in enumerate(names) if name in ("ax", "az")]
    if turning:
        growth = errors[:count] / known.without(turning).errors[:count]
        worst = int(growth.argmax())
        if growth[worst] > DISTURBED:
            increased = say(
                "the auto-compensating rotation increases the standard error of {constant} by a factor of {factor:.2g}",
                constant=names[worst],
                factor=float(growth[worst]),
            )
            remedy = say("choose another period of the rotation, or another range of angles")
            findings.append(Finding("turn", increased, say("its period is near that of an error"), remedy))
    findings += _sparse(gimbals, harmonics)
    ratios = errors / (math.inf if prior is None else prior)
    little = [name for name, ratio in zip(names, ratios, strict=True) if ratio > UNTOLD and name[0] in "SC"]
    if little:
        untold = say(
            "the samples carry little information about {constants}: their estimates depend mostly on the prior",
            constants=", ".join(little),
        )
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
                "span",
                say("the angle {angle} moves by {span:.3g} deg, less than one period of its harmonic {order} "
                    "({period:.3g} deg)", angle=angle, span=math.degrees(span), order=min(orders),
                    period=math.degrees(period)),
                say("its harmonics can hardly be separated: {first} correlates with {second} by {correlation:+.3f}",
                    first=names[mine[i]], second=names[j], correlation=float(correlation[mine[i], j])),
                say("choose a longer interval, or a part of the day where the angle moves faster"),
            )  # fmt: skip


def _alike(names: tuple[str, ...], correlation: FloatArray) -> Iterator[Finding]:
    size = np.abs(np.triu(correlation[: len(names), : len(names)], 1))
    pairs = sorted(np.argwhere(size > ALIKE).tolist(), key=lambda ij: -size[ij[0], ij[1]])
    if pairs:
        worst = [
            say(
                "{first} and {second} ({correlation:+.2f})",
                first=names[i],
                second=names[j],
                correlation=float(correlation[i, j]),
            )
            for i, j in pairs[:3]
        ]
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
            yield Finding("sparse",
                          say("between two samples ({step:.4g} s) {angle} moves by up to {periods:.2g} periods of its "
                              "harmonic {order}", step=float(step[worst]), angle=angle, periods=float(moved[worst]),
                              order=max(orders)),
                          say("an error between the samples is not observed, and angle and cosine must be sampled at "
                              "the same instant"),
                          say("sample at least four times per period"))  # fmt: skip
