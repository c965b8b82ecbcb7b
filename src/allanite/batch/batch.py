"""Batch: the results of many units, each by its file."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from allanite.core.errors import UsageError
from allanite.core.limits import FAIL, NOT_DECIDED, Stored
from allanite.core.names import told_apart
from allanite.core.plain import Value
from allanite.core.record import Record
from allanite.readers.sandbox.source import STDIN, STDIN_NAME
from allanite.study.results import Channel, Noise, Study

from .specification import Judgement, Specification, judge_study, worst_of
from .tables import Across, across


@dataclass(frozen=True, eq=False, repr=False)
class BatchUnit(Value):
    """One unit: the study of its file, or why there is none (`error`), and what the limits say of it."""

    _also = ("outcome",)

    file: str
    study: Study | None = None
    judgements: tuple[Judgement, ...] = ()
    error: str = ""
    judged: bool = False

    @property
    def outcome(self) -> str:
        """The worst outcome of its limits, "not decided" where none was applied; empty where none are given."""
        if not self.judged:
            return ""
        return worst_of([judgement.outcome for judgement in self.judgements]) or NOT_DECIDED

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The results of its channels."""
        study = self.study
        return () if study is None else study.channels

    def _summary(self) -> str:
        return f"{self.file!r}: {self.error or self.outcome or 'analyzed'}"


@dataclass(frozen=True, eq=False, repr=False)
class Batch(Value):
    """The same analysis of many units.

    ``batch["units/a.csv"]`` and ``batch[0]`` are units; it can be iterated over.

    Attributes
    ----------
    units : tuple of BatchUnit
        In the order in which their files were named.
    choices : dict
        The recipe, as plain data.
    level : float
        Of intervals.
    specification : Specification or None
        The limits.
    notes : tuple of str
        What was left out.
    """

    _also = ("failed", "exceeding", "across")

    units: tuple[BatchUnit, ...]
    choices: dict[str, Any]
    level: float = 0.95
    specification: Specification | None = None
    notes: tuple[str, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, key: str | int) -> BatchUnit:
        if isinstance(key, int):
            return self.units[key]
        for unit in self.units:
            if unit.file == key:
                return unit
        raise UsageError(f"no unit {key!r}; there are {', '.join(unit.file for unit in self.units)}")

    def __iter__(self) -> Iterator[BatchUnit]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    def results(self) -> Iterator[tuple[str, Channel]]:
        """File and channel of each result; of a lot, one study at a time is in memory."""
        return ((unit.file, channel) for unit in self for channel in unit.channels)

    @property
    def failed(self) -> tuple[str, ...]:
        """Files that could not be analyzed."""
        return tuple(unit.file for unit in self.units if unit.error)

    @property
    def exceeding(self) -> tuple[str, ...]:
        """Files of units that exceed a limit."""
        return tuple(unit.file for unit in self.units if unit.outcome == FAIL)

    @property
    def rejected(self) -> tuple[str, ...]:
        """What has no result, is not explained by its model, or has a limit that is not decided: file and channel."""
        without = [f"{unit.file}: {name or 'the record'}" for unit in self.units if unit.study for name in
                 unit.study.rejected]  # fmt: skip
        open_ = [f"{unit.file}: {NOT_DECIDED}" for unit in self.units if unit.outcome == NOT_DECIDED and not unit.error]
        return (*without, *open_)

    @cached_property
    def across(self) -> tuple[Across, ...]:
        """Mean, spread and worst of each coefficient over the units."""
        return across(self.results(), self.level)

    @cached_property
    def folder(self) -> str:
        """The folder that all files have in common; empty where there is none but the working one."""
        files = [unit.file for unit in self.units if unit.file != STDIN]
        try:
            return os.path.commonpath([os.path.dirname(file) for file in files]) if files else ""
        except ValueError:  # some paths are absolute, others are not
            return ""

    def label(self, unit: BatchUnit) -> str:
        """The name of a unit, which tells its file apart from the others."""
        return self._labels[unit.file]

    @cached_property
    def _labels(self) -> dict[str, str]:
        files = list(dict.fromkeys(unit.file for unit in self.units))
        return dict(zip(files, told_apart([STDIN_NAME if file == STDIN else file for file in files]), strict=True))

    def _summary(self) -> str:
        return f"{len(self.units)} units, {len(self.failed)} failed, {len(self.exceeding)} exceed a limit"


def unit_of(file: str, study: Study, limits: Specification | None) -> BatchUnit:
    """The unit of a file that could be analyzed, held against the limits."""
    return BatchUnit(file, study, () if limits is None else judge_study(study, limits), judged=limits is not None)


def lightened(study: Study, *, samples: bool = False) -> Study:
    """A study without alternative models and, but for a single one, whose figures show `samples`, without records."""
    channels = []
    for channel in study.channels:
        record = channel.record.header if isinstance(channel.record, Record) and not samples else channel.record
        noise = channel.noise
        if noise is not None:
            residuals = None if noise.residuals is None else Stored(noise.residuals)
            noise = Noise(replace(noise.fit, rivals=None), residuals)
        channels.append(replace(channel, record=record, noise=noise))
    return replace(study, channels=tuple(channels), common=study.shared)
