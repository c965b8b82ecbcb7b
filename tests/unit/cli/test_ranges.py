"""Every number that may be given has a range: what lies beyond it is refused by name, and nothing else is kept."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields
from importlib import import_module
from typing import get_args

import click
import numpy as np
import pandas as pd
from tests.rows import refused, rows

import allanite as al
from allanite.cli import main
from allanite.cli.options import Converted
from allanite.core.choices import Choices, choices_of
from allanite.core.ranges import LEVEL, PART, RATE, TIME, Range

VALUES = (0, -1, 1e-300, 5e-324, 1e300, math.nan, math.inf, -math.inf, 10**400)
TEXTS = (*map(str, VALUES[:-1]), "1e400", "9" * 400, "-0.0", "1e-9", "1e15")
FORMS = ("{0}", "{0},{0}", "{0}..{0}", "1,{0}", "N={0}:{0}", "{0},{0},{0},{0}", "{0}s", "1..{0}", "N=1:{0}", "{0}%")
MODULES = (
    "study.settings", "study.recipe", "study.survey", "study.modelled", "study.watching", "claims.drift_settings",
    "comparison.comparison", "exporting.fields", "applications.attitude.result", "applications.constant_rate.campaign",
    "applications.compensation.settings",
)  # fmt: skip


def options(command=main, path=()):
    """Every option of every verb that takes a value."""
    if isinstance(command, click.Group):
        for name in command.list_commands(click.Context(command)):
            yield from options(command.get_command(click.Context(command), name), (*path, name))
    else:
        yield from ((path, p) for p in command.params if isinstance(p, click.Option) and not p.is_flag)


def numbers(value):
    """The numbers in a value."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        yield value
    elif isinstance(value, Iterable) and not isinstance(value, str):
        for item in value.values() if isinstance(value, Mapping) else value:
            yield from numbers(item)


def settings():
    """Every class of choices, and those derived from it."""
    kinds = [Choices] if all(import_module(f"allanite.{name}") for name in MODULES) else []
    for kind in kinds:
        kinds += kind.__subclasses__()
        if kind is not Choices and not kind.__module__.startswith("tests"):
            yield kind


def kept(call):
    """What a call returns, and the error that it ends with."""
    try:
        return call(), None
    except al.UsageError as error:
        return None, error


def members(hint):
    """The types in a declared type, those of items too."""
    return {hint, *(inner for part in get_args(hint) for inner in members(part))}


def test_an_option_keeps_numbers_of_its_range_alone():
    for path, option in options():
        assert not isinstance(option.type, (click.types.FloatParamType, click.types.IntParamType)), (path, option.name)
        if not isinstance(option.type, Converted):
            continue
        within = option.type.within or option.type.kind.within
        for text in {form.format(text) for text in TEXTS for form in FORMS}:
            value, refusal = kept(lambda option=option, text=text: option.type.convert(text, option, None))
            assert refusal is None or str(refusal).startswith("Invalid value for '--"), (path, option.name, text)
            for number in numbers(value):
                assert within is not None and within.holds(number), (path, option.name, text)  # noqa: PT018 - one


def test_a_field_keeps_numbers_of_its_range_alone():
    tried = 0
    for kind in settings():
        needed = {"regressors": ("temp",)} if kind.__name__ == "CompensationSettings" else {}
        declared = {f.name: members(f.type) for f in fields(kind)}
        for name, row in choices_of(kind).items():
            within = row.within or row.kind.within
            if not {int, float} & declared[name]:
                continue
            assert isinstance(within, Range), (kind, name)
            for value in (v for number in VALUES for v in (number, (number,), (number, number))):
                tried += 1
                made, refusal = kept(lambda kind=kind, more=needed | {name: value}: kind(**more))
                assert refusal is None or refusal.choice or name in str(refusal), (kind, name, value, refusal)
                now = None if made is None else getattr(made, name)
                assert now == row.default or within.holds(now), (kind, name, value)
    assert tried > 3000


@rows("within, value, words", [
    (RATE, 0, "the sampling rate must be between 1e-09 and 1e+15 Hz, not 0"),
    (TIME, (1, math.nan), "a time must be between 1e-15 and 1e+12 s, not (1, nan)"),
    (LEVEL, 95, "a confidence level must be between 0 and 1, not 95; did you mean 0.95?"),
    (PART, 0, "a time must be above 0 and at most 1, not 0"),
    (Range(0, 1, below=True), 1, "a time must be at least 0 and below 1, not 1"),
    (RATE, 10**400, "the sampling rate must be between 1e-09 and 1e+15 Hz, not a number of more than 200 digits"),
])  # fmt: skip
def test_a_range_says_what_came_and_what_is_expected(within, value, words):
    refused(al.UsageError, f"^{re.escape(words)}$", lambda: within.demand(value, "a time"))


NOISE = al.N(1.0, "rad/sqrt(s)")
RECORD = al.simulate(NOISE, 400, 100.0, rng=1)


@rows("call, words", [
    (lambda: al.Model("GM 1 deg/h 1e-308 s"), "time_constant of GM must be between 1e-15"),
    (lambda: al.state_space(al.Model("GM 1 deg/h 1e9 s"), 1e9), "over the sampling interval must be"),
    (lambda: al.drift(NOISE, calibration=5e-324), "calibration that is not 0 must be between 1e-09"),
    (lambda: al.expected(NOISE, "oadev", [1e-300]), "averaging times must be above 0 s"),
    (lambda: al.simulate(NOISE, rate=10.0, duration=1e308), "duration must be between"),
    (lambda: al.deviation(pd.DataFrame({"gx": RECORD.values}), "gx"),
     "statistic is 'gx', a column: select it with channels='gx'"),
])  # fmt: skip
def test_numbers_beyond_sense_reach_no_mathematics(call, words):
    refused(al.AllaniteError, words, call)


def test_ordinary_numbers_of_odd_records_raise_no_warning():
    two_valued = al.Record(np.arange(400) % 2 * 1.0, 100.0, "rad/s")
    assert al.identify(two_valued, terms="K").method == "whittle"
    pair = al.compare(RECORD, two_valued)[0]
    low, high = pair["N"].interval(1e-12)
    assert low <= high
    assert np.isfinite(pair.ratios.ratio).any()


@rows("value, name, words", [
    (RECORD, "valuse", "did you mean values?"), (NOISE, "sgnal", "did you mean signal?"),
    (al, "stride", "dir(allanite) lists"),
])  # fmt: skip
def test_a_misspelled_name_is_told(value, name, words):
    refused(AttributeError, re.escape(words), lambda: getattr(value, name))
