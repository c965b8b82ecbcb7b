"""A state of the search: the components of a record beside its powers, with their shapes; it never changes."""

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

from .components import BROAD, COMPONENTS, HIDING, LEAST_MARKOV, SECOND, Part, at_bound, cost_of
from .frame import Frame

ORDER = tuple(COMPONENTS)  # order of the parts of a state


@dataclass(frozen=True)
class State:
    """Parts in the order of the table, those of a row by their shapes."""

    parts: tuple[Part, ...] = ()

    def __iter__(self) -> Iterator[Part]:
        return iter(self.parts)

    def having(self, *parts: Part) -> "State":
        """The state with more parts."""
        return State(tuple(sorted((*self.parts, *parts), key=lambda p: (ORDER.index(p.name), p.shape, p.label))))

    def lacking(self, *parts: Part) -> "State":
        """The state without some parts."""
        kept = list(self.parts)
        for part in parts:
            kept.remove(part)
        return State(tuple(kept))

    def of(self, name: str) -> tuple[Part, ...]:
        """Its parts of one row."""
        return self._of.get(name, ())

    @cached_property
    def _of(self) -> dict[str, tuple[Part, ...]]:
        return {name: tuple(parts) for name, parts in groupby(self.parts, lambda part: part.name)}

    @cached_property
    def filter(self) -> Part | None:
        """Its low-pass filter."""
        return next(iter(self.of("filter")), None)

    @cached_property
    def family(self) -> tuple[tuple[str, int], ...]:
        """What it consists of: rows, numerators and places are alternatives of one family."""
        return tuple(sorted(Counter(p.label if p.name == "noise" else p.name for p in self.parts).items()))

    @cached_property
    def kind(self) -> tuple[tuple[str, str, tuple[int, ...]], ...]:
        """The same with shapes, rounded: states of the same kind are the same."""
        return tuple(sorted((p.name, p.label, _rounded(p)) for p in self.parts))

    @cached_property
    def form(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """The kind, whatever the numerators of its resonances and the row of its filter."""
        return tuple(sorted((name, shape) for name, _, shape in self.kind))

    @property
    def needs_white(self) -> bool:
        """Whether white noise must stand beside its parts, as these could take its place: see `components`."""
        return any(
            p.name == "factor" or (p.name == "noise" and len(p.shape) == 1 and p.shape[0] < LEAST_MARKOV)
            for p in self.parts
        )

    @property
    def lacks_flicker(self) -> bool:
        """Whether a power law stands in the place of flicker."""
        return bool(self.of("exponent"))

    def admitted(self, frame: Frame) -> bool:  # noqa: PLR0911 - a rule a line
        """Whether its parts may stand together."""
        counts = Counter(p.name for p in self.parts)
        if any(count > COMPONENTS[name].most for name, count in counts.items()):
            return False
        if any(at_bound(part, frame) for part in self.parts):
            return False
        if self.needs_white and frame.white is None and counts["factor"]:
            return False
        if not frame.powers and not any(COMPONENTS[name].inside for name in counts):
            return False
        if sum(p.shape[1] < BROAD for p in self.of("resonance")) > 1:
            return False
        if frame.common and self.filter is None:
            return False
        if counts["factor"] and self.hides_angle:
            return False  # below it the factor is the filter by another name
        if counts["floor"]:
            return self.filter is not None and self.filter.shape[0] >= HIDING
        return True

    def cost(self, frame: Frame) -> float:
        """What its parts cost in the score."""
        more = [part for part in self.of("noise")[1:] if part.label not in frame.asked]
        return sum(cost_of(part, frame) for part in self.parts) + SECOND * len(more)

    @property
    def rises(self) -> bool:
        """Whether it has a filter or resonances, beside whose shapes angle noise gains."""
        return self.filter is not None or bool(self.of("resonance"))

    @property
    def hides_angle(self) -> bool:
        """Whether its filter is so low that angle noise behind it is white."""
        return self.filter is not None and self.filter.shape[0] < HIDING


def _rounded(part: Part) -> tuple[int, ...]:
    grain = COMPONENTS[part.name].grain
    return tuple(round(math.log(max(x, 1e-9)) / step) for x, step in zip(part.shape, grain, strict=False))


def alike(state: State, other: State) -> bool:
    """Whether two states are the same but for less than the grain of their shapes."""
    if len(state.parts) != len(other.parts):
        return False
    for p, q in zip(state, other, strict=True):
        if p[:2] != q[:2]:
            return False
        steps = zip(p.shape, q.shape, COMPONENTS[p.name].grain, strict=False)
        if any(abs(math.log(max(a, 1e-9) / max(b, 1e-9))) > step for a, b, step in steps):
            return False
    return True
