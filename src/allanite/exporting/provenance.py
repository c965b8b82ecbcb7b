"""The comments at the head of a file: what made it, from what, and what it leaves out."""

from collections.abc import Iterator, Sequence

from allanite.core.fit import Fit
from allanite.core.kinds import title_of
from allanite.core.validity import graded
from allanite.core.version import __version__
from allanite.phrases.phrase import say

from .bounds import BOUND, READ
from .content import Axis, by_sensor
from .fields import How
from .target import Target


def header(target: Target, axes: Sequence[Axis], how: How) -> Iterator[str]:
    """The lines of the head, the same for the same input."""
    yield f"{target.title}, written by allanite {__version__}"
    for source, digest in dict.fromkeys((a.source.get("source", ""), a.source.get("sha256", "")) for a in axes):
        yield f"source: {source or 'noise model given'}" + (f", sha256 {digest}" if digest else "")
    for sensor, group in by_sensor(axes).items():
        names = ", ".join(axis.name or "given" for axis in group)
        rates = ", ".join(dict.fromkeys(f"{axis.rate:.9g} Hz" for axis in group if axis.rate))
        yield f"{sensor}: {names}{f' at {rates}' if rates else ''}"
        for axis in group:
            yield from (f"  {axis.label}: {line}" for line in _fitted(axis.fit, axis.doubt))
            yield from (f"  {axis.label}: warning: {alert}" for alert in axis.alerts)
    yield f"axis: {how.axis}; inflation: {how.inflate:g}"
    if target.fields:
        yield f"values: {time_of(target, axes, how)}"
    yield from (f"note: {note}" for note in target.notes)


def _fitted(fit: Fit, doubt: str) -> Iterator[str]:
    if fit.method == "given":
        yield f"{fit.model}"
        return
    if fit.method == READ:
        yield BOUND
        return
    scope = fit.scope
    band = "" if scope is None else f", {scope.band[0]:.4g} to {scope.band[1]:.4g} Hz"
    grade = f", {graded(fit.validity, scope)}" if fit.validity else ""
    yield f"method {fit.method}{band}{grade}{f' ({doubt})' if doubt else ''}"


def time_of(target: Target, axes: Sequence[Axis], how: How) -> str:
    """Whether the fields of a target are of continuous or of discrete time, and at which rate."""
    if not any(field.rate for field in target.fields):
        return "continuous time (densities), whatever the rate"
    rates = dict.fromkeys(target.rate(axis.rate, how.filter_rate) for axis in axes)
    words = ", ".join(f"{rate:.9g} Hz" for rate in rates if rate)
    return f"discrete time, f = {words}" + (f" (the filter's step of {target.step:g} s)" if target.step else "")


def left_out(target: Target, axes: Sequence[Axis]) -> Iterator[str]:
    """Terms that were identified and for which the target has no field."""
    if not target.fields:
        return
    for axis in axes:
        terms = {field.term for field in target.fields if field.sensor == axis.sensor}
        terms |= {"GM"} if target.markov and not any(e.symbol == "K" and e.valued for e in axis.fit) else set()
        lost = [e for e in axis.fit if e.valued and e.symbol not in terms]
        for e in lost:
            name = title_of(e.symbol, e.signal)
            yield say("{axis}: no field for {symbol} ({name}), {words}",
                      axis=axis.label, symbol=e.symbol, name=name, words=e.words(level=axis.level))  # fmt: skip
        for line in axis.fit.lines:
            yield say("{axis}: no field for the sinusoid at {line}", axis=axis.label, line=line.words())
