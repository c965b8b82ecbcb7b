"""Whether the drift of channels follows another column of their file, and the command that removes it."""

import shlex
from collections.abc import Sequence

from allanite.core.record import Recording
from allanite.core.validity import Finding
from allanite.phrases.phrase import percent, say
from allanite.prepare.drift import follows

from .recipe import READING, SELECTING, Recipe

OPTIONS = {"start": "from"}  # options whose names differ from the recipe's keys


def drift_findings(recording: Recording, recipe: Recipe, names: Sequence[str]) -> tuple[Finding, ...]:
    """A finding for each additional column that the drift of some channels follows."""
    findings = []
    for other in recording.others:
        by_name = ((name, follows(recording[name], other)) for name in names)
        shares = {name: following.share for name, following in by_name if following and following.clear}
        if shares:
            largest = max(shares.values())
            findings.append(Finding(
                "drift",
                say(
                    "the drift of {channels} follows {column}, up to {share} of the variance of block means",
                    channels=", ".join(shares), column=other.name, share=percent(largest),
                ),
                say("B, K and R partly represent the sensitivity to it"),
                say("remove it: {command}", command=compensation(recording.source, recipe, other.name)),
            ))  # fmt: skip
    return tuple(findings)


def compensation(source: str, recipe: Recipe, column: str) -> str:
    """The command that removes the dependence on a column.

    >>> compensation("my day.csv", Recipe(unit="deg/s", start=10.0, channels=("gx", "gy")), "temp")
    "allanite compensate 'my day.csv' --unit deg/s --channels gx,gy --from 10.0 --regressors temp"
    """
    words = ["allanite", "compensate", source]
    for key, value in recipe.to_dict((*READING, *SELECTING)).items():
        text = ",".join(map(str, value)) if isinstance(value, list) else str(value)
        words += [f"--{OPTIONS.get(key, key).replace('_', '-')}", text]
    return shlex.join([*words, "--regressors", column])
