"""Export: the file that a target reads, from results or from a given model."""

import base64
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

from allanite.core.aliases import public
from allanite.core.choices import SPAN
from allanite.core.errors import DataError, UsageError
from allanite.core.files import PathLike, encoded, write
from allanite.core.fit import Fit
from allanite.core.kinds import title_of
from allanite.core.plain import Value
from allanite.core.record import Record, Recording
from allanite.core.validity import graded
from allanite.core.version import __version__
from allanite.phrases.phrase import say, spelled
from allanite.study.analysis import analyze
from allanite.study.recipe import Recipe
from allanite.study.results import Study

from .choice import BOUND, READ, Source, axes_of, bounded, demand_policy, selected
from .content import Axis, Content, Entry, by_sensor
from .cover import covered
from .exports import target_named
from .fields import How, demand_how, fill, usable, with_identified
from .stated_noise import StatedNoise, compared, groups_of, to_cover
from .target import Target, demand_rate


@dataclass(frozen=True, eq=False, repr=False)
class Export(Value):
    """A file for a target.

    Attributes
    ----------
    target : str
        Its name in `EXPORTS`.
    suffix : str
        Form of the file.
    text : str
        The file; base64 if it is `binary`.
    entries : tuple of Entry
        The fields; empty for targets that take whole models.
    stated : tuple of StatedNoise
        How the noise model of the file compares with that of the record; empty for targets that take whole models.
    notes : tuple of str
        What the target has no field for, and what users must know.
    alerts : tuple of str
        Warnings.
    rejected : tuple of str
        Channels that were left out.
    recipe : dict
        The recipe of the analysis.
    provenance : dict
    """

    target: str
    suffix: str
    text: str
    binary: bool = False
    entries: tuple[Entry, ...] = ()
    stated: tuple[StatedNoise, ...] = ()
    notes: tuple[str, ...] = ()
    alerts: tuple[str, ...] = ()
    rejected: tuple[str, ...] = ()
    recipe: dict[str, Any] = field(default_factory=dict)
    provenance: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        try:
            self.data  # noqa: B018 - that there are bytes
        except ValueError:
            raise UsageError("the text of a binary file is base64: these data were changed") from None

    @property
    def data(self) -> bytes:
        """The bytes of the file."""
        return base64.b64decode(self.text) if self.binary else encoded(self.text)

    def __getitem__(self, name: str) -> float:
        """The value of a field in its unit, of the first axis if there are several."""
        for entry in self.entries:
            if entry.full == name:
                return entry.values[0]
        raise UsageError(f"there is no field {name!r}; fields: {', '.join(entry.full for entry in self.entries)}")

    def write(self, path: PathLike, *, force: bool = False) -> None:
        """Write the file.

        Raises
        ------
        UsageError
            The file exists and `force` is not set, or cannot be written.
        """
        write(path, self.data, force=force)

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: a field each."""
        return ["field", "value", "identified", "unit", "factor", "remark", "formula", "channel"], [
            [e.full, _numbers(e.values), _numbers(e.identified), e.unit, "" if e.factor is None else f"{e.factor:.3g}",
             e.remark, e.formula, ", ".join(dict.fromkeys(e.channels))]
            for e in self.entries
        ]  # fmt: skip

    def _summary(self) -> str:
        return f"for {self.target}: {len(self.data)} bytes of {self.suffix}"


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.6g}" for value in dict.fromkeys(values))


@public
def export(  # noqa: PLR0913 - each has a default, and is a choice of its own
    source: Source | Record | Recording | str | os.PathLike[str], target: str, *, axis: str = "worst",
    inflate: float = 1.0, rate: float | None = None, filter_rate: float | None = None, unexplained: bool = False,
    cover: bool | str | tuple[float, float] | None = None, from_curve: bool = False, form: str = "",
) -> Export:  # fmt: skip
    """Convert identified noise to the file that a filter or simulator reads.

    Parameters
    ----------
    source : Study, Channel, Fit, Model, Term, or a sequence of these; Record, Recording or path
        Several are put together: a gyro's and an accelerometer's. Recordings are analyzed.
    target : str
        A name in `EXPORTS`.
    axis : {"worst", "median", "x", "y", "z", "each"}
        Whose coefficient is written: the largest or the middle one of the axes of a sensor, one axis, or each axis
        its own where the target takes three values.
    inflate : float
        Factor on every coefficient; it is written into the file.
    rate : float, optional
        Sampling rate in Hz of fits and models that do not know it, if the target needs it.
    filter_rate : float, optional
        Rate of the filter's steps in Hz, for fields of discrete time; by default the target's own, or the sampling
        rate.
    unexplained : bool
        Whether coefficients are exported although no model explains the record.
    cover : bool or (low, high), optional
        Whether the file covers the noise and its upper limits, see `StatedNoise`: between two averaging times in s; or
        True, from 1 s to a tenth of the record. By default where a filter has no field for what was identified, and
        would be over-confident.
    from_curve : bool
        Whether upper bounds, read off the measured Allan deviation, are exported where no model explains the record or
        a coefficient has neither a value nor a limit. The file says so.
    form : str
        Suffix of the form, of a target that has several: ".npz", ".m" or ".h" of "statespace".

    Returns
    -------
    Export

    Raises
    ------
    UsageError
        The target or its form is unknown, a choice is impossible, or the rate is missing.
    DataError
        A sensor that the target needs is missing, no model explains the records, or a coefficient has neither a value
        nor an upper limit.

    Examples
    --------
    >>> import allanite as al
    >>> gyro = al.Model("N 0.15 deg/sqrt(h), K 3 deg/h/sqrt(h)")
    >>> accelerometer = al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")
    >>> found = al.export([gyro, accelerometer], "vins-mono", rate=200.0)
    >>> round(found["gyr_n"], 7)
    0.0008727
    >>> flicker = al.Model("N 0.3 deg/sqrt(h), B 7.2 deg/h")
    >>> covering = al.export([flicker, accelerometer], "kalibr", rate=200.0, cover=(1, 300))
    >>> print(covering.stated[0].model)
    N = 0.6329 deg/sqrt(h), K = 35.55 deg/h/sqrt(h)
    """
    how = How(axis, inflate, rate, filter_rate, unexplained, SPAN.demand("cover", cover), from_curve)
    row, suffix = prepared(target, how, form)
    if isinstance(source, Record | Recording | str | os.PathLike):
        source = analyze(source, None if isinstance(source, Value) else Recipe(rate=rate))
    return exported(row, source, how, suffix)


def prepared(target: str, how: How, suffix: str) -> tuple[Target, str]:
    """The row of a target and the suffix of its form, after checking the choices."""
    row = target_named(target)
    demand_policy(how.axis)
    demand_how(row, how)
    return row, row.form(suffix)


def exported(target: Target, source: Source, how: How, suffix: str) -> Export:
    """The file of a target for a source, in the form of one of its suffixes."""
    axes = _axes(source, how)
    kept = usable(axes, how, target.sensors)
    groups = groups_of(kept, how) if target.drifts else []
    stand = covered(target, kept, to_cover(target, kept, groups, how), asked=how.span is not None)
    entries, missing = fill(target, stand, how)
    entries = with_identified(entries, target, kept, how)
    stated = tuple(noise for group in groups if (noise := compared(target, entries, group, how)) is not None)
    if not target.fields:
        kept = tuple(axis for group in by_sensor(kept).values() for axis in selected(group, how.axis))
    rate = next((target.rate(axis.rate, how.filter_rate) for axis in kept), None)
    if not how.partial:
        demand_rate(target, rate)
    doubts = [axis for axis in axes if axis.doubt and not how.unexplained]
    plain = [say("{option} writes the identified values", option=spelled("--cover=no", "cover=False"))]
    notes = (*(plain if any(entry.covers for entry in entries) else ()), *missing, *left_out(target, stand),
             *(line for made in stated if made.covers for line in made.words()))  # fmt: skip
    known = 1 if target.simulates else None  # what it says of filters is none of a simulator's business
    warned = [line for made in stated if made.confident for line in made.words()[:known]]
    head = (*header(target, kept, how), *notes, *warned, *(f"left out: {axis.name} ({axis.doubt})" for axis in doubts))
    made = target.forms[suffix](Content(head, entries, kept, rate, how.inflate))
    binary = isinstance(made, bytes)
    text = base64.b64encode(made).decode() if isinstance(made, bytes) else made
    studies = [s for s in (source if isinstance(source, (list, tuple)) else (source,)) if isinstance(s, Study)]
    recipe, provenance = (studies[0].choices(), studies[0].provenance) if studies else ({}, {})
    rejected = dict.fromkeys(chain((axis.name for axis in doubts), *(study.rejected for study in studies)))
    return Export(target.name, suffix, text, binary, entries, stated, (*notes, *target.notes),
                  (*alerts_of(kept, doubts, studies), *warned), tuple(rejected), recipe, provenance)  # fmt: skip


def _axes(source: Source, how: How) -> tuple[Axis, ...]:
    """The axes of gyros and accelerometers with their bounds."""
    axes = list(axes_of(source))
    inertial = [axis for axis in axes if axis.fit.signal.inertial]
    if axes and not inertial:
        names = ", ".join(f"{axis.label!r} ({axis.sensor})" for axis in axes)
        raise DataError(f"files for other programs hold the noise of gyroscopes and accelerometers, not of {names}; "
                        "write the coefficients of any quantity with "
                        + spelled("'allanite analyze FILE --coefficients PATH'", "fit.rows()"))  # fmt: skip
    known = how.rate or next((axis.rate for axis in inertial if axis.rate), None)
    return tuple(bounded(replace(axis, rate=axis.rate or known), asked=how.from_curve) for axis in inertial)


def alerts_of(kept: Sequence[Axis], doubts: Sequence[Axis], studies: Sequence[Study]) -> list[str]:
    """Warnings, those that several channels share once."""
    alerts: dict[str, list[str]] = {}
    for axis in kept:
        for alert in (*axis.alerts, *([axis.doubt] if axis.doubt else [])):
            alerts.setdefault(alert, []).append(axis.name)
    remarks = [str(finding) for study in studies for finding in study.findings]
    for alert, names in alerts.items():
        about = say("all channels") if len(names) == len(kept) > 1 else ", ".join(names)
        remarks.append(say("{names}: {alert}", names=about, alert=alert))
    remarks += [say("{name} is left out: {reason}", name=axis.name, reason=axis.doubt) for axis in doubts]
    refused = [channel for study in studies for channel in study if channel.refusal]
    return remarks + [say("{name} is left out: {reason}", name=c.record.name, reason=c.refusal) for c in refused]


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
            yield f"  {axis.label}: {_fitted(axis.fit, axis.doubt)}"
            yield from (f"  {axis.label}: warning: {alert}" for alert in axis.alerts)
    yield f"axis: {how.axis}" + (f"; inflation: {how.inflate:g}" if how.inflate != 1 else "")
    if target.fields:
        yield f"values: {time_of(target, axes, how)}"
    yield from (f"note: {note}" for note in target.notes)


def _fitted(fit: Fit, doubt: str) -> str:
    if fit.method in ("given", READ):
        return BOUND if fit.method == READ else f"{fit.model}"
    scope = fit.scope
    band = "" if scope is None else f", {scope.band[0]:.4g} to {scope.band[1]:.4g} Hz"
    grade = f", {graded(fit.validity, scope)}" if scope is not None and (scope.misfit or scope.until) else ""
    return f"method {fit.method}{band}{grade}{f' ({doubt})' if doubt else ''}"


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
        if axis.fit.lines:
            every = ", ".join(f"{line.frequency:.4g}" for line in axis.fit.lines)
            yield say("{axis}: no field for sinusoids at {frequencies} Hz", axis=axis.label, frequencies=every)
