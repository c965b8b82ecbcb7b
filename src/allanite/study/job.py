"""The result of a job over the channels of a recording, and where its numbers come from."""

import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, ClassVar, Generic, Self, TypeVar, get_args

from allanite.core.encoding import read_key, write_plain
from allanite.core.names import demand_name
from allanite.core.plain import VERSION, Value, read_fields, stored_fields
from allanite.core.record import Recording
from allanite.core.validity import Finding
from allanite.core.version import __version__

from .recipe import IDENTIFYING, READING, SELECTING, Recipe


def provenance_of(*recordings: Recording) -> dict[str, str]:
    """Version and input files, for reproducing the result."""
    made = {"allanite": __version__, "python": platform.python_version()}
    return made | joined([{"source": recording.source, "sha256": recording.digest} for recording in recordings])


def joined(provenances: Sequence[Mapping[str, str]]) -> dict[str, str]:
    """Those of several files as one: ``source``, ``source 2`` and so on."""
    first = dict(provenances[0]) if provenances else {}
    more = enumerate(provenances[1:], 2)
    return first | {f"{key} {i}": provenance[key] for i, provenance in more
                    for key in ("source", "sha256") if key in provenance}  # fmt: skip


Result = TypeVar("Result")


@dataclass(frozen=True, eq=False, repr=False)
class Job(Value, Generic[Result]):
    """Result of a job: one result per channel, and how it was obtained.

    A subclass defines the type of its channels in `_channel`; its own fields are written and read with the others.

    Attributes
    ----------
    channels : tuple
        One result per channel, in the order of the file; each has its `record`, and a `refusal` if there is no result.
    recipe : Recipe
    findings : tuple of Finding
        Findings about the file as a whole: its clock.
    notes : tuple of str
        Assumptions made when reading.
    provenance : dict
        Version and input files.
    """

    _channel: ClassVar[type[Any]]
    _used: ClassVar[tuple[str, ...] | None] = (*READING, *SELECTING, *IDENTIFYING)  # of the recipe; None for all

    channels: tuple[Result, ...]
    recipe: Recipe
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    provenance: dict[str, str]

    def __getitem__(self, key: str | int) -> Result:
        if isinstance(key, int):
            return self.channels[key]
        demand_name("channel", key, self._names)
        return self.channels[self._names.index(key)]

    def __iter__(self) -> Iterator[Result]:
        return iter(self.channels)

    def _named(self, name: str) -> Any:
        return self[name] if name in self._names else None

    @property
    def _names(self) -> list[str]:
        """Names of the channels: their own, or those of their records."""
        channels: tuple[Any, ...] = self.channels
        return [channel.name if hasattr(channel, "name") else channel.record.name for channel in channels]

    @property
    def apart(self) -> "list[tuple[str, Self]]":
        """The channels that have a result: the name of each, and the job with it alone."""
        pairs = zip(self._names, self.channels, strict=True)
        return [(name, replace(self, channels=(channel,))) for name, channel in pairs if not channel.refusal]  # type: ignore[attr-defined]

    @property
    def rejected(self) -> tuple[str, ...]:
        """Names of the channels without a result, or whose noise no model explains."""
        pairs = zip(self._names, self.channels, strict=True)
        return tuple(name for name, channel in pairs if channel.refusal or not self._explained(channel))  # type: ignore[attr-defined]

    def _explained(self, channel: Any) -> bool:
        """Whether no model is known to be inadequate for the noise of a channel, if it was identified."""
        return channel.noise is None or bool(channel.noise.explained)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        return self.recipe.to_dict(self._used)

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        level = self.recipe.level if level is None else level
        channels: tuple[Any, ...] = self.channels
        own = {name: write_plain(getattr(self, name), hint, level) for name, hint in stored_fields(type(self), Job)}
        return {"allanite": VERSION, "type": type(self).__name__, "channels": [c.to_dict(level) for c in channels],
                "findings": [finding.to_dict() for finding in self.findings], "recipe": self.choices(),
                "notes": list(self.notes), "provenance": self.provenance, **own}  # fmt: skip

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        # keys of settings of the same name are not those of the recipe
        hints = [hint for name, hint in stored_fields(cls, Job) if name == "settings"]
        kinds = [kind for hint in hints for kind in get_args(hint) or (hint,) if is_dataclass(kind)]
        known = {f.name for f in fields(Recipe)} - {f.name for kind in kinds for f in fields(kind)}
        recipe = {key: value for key, value in read_key(data, "recipe", dict[str, Any]).items() if key in known}
        read = {"channels": tuple[cls._channel, ...], "recipe": Recipe}  # type: ignore[name-defined]
        both = {key: read_key(data | {"recipe": recipe}, key, hint) for key, hint in read.items()}
        return cls(**both, **read_fields(cls, data, *both))

    def _summary(self) -> str:
        source = self.provenance.get("source") or "data in memory"
        return f"{source!r}: {', '.join(name or 'channel' for name in self._names)}"
