"""Expected curves of a given model: what the deviations of a file would be, without the file."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from allanite.core.errors import UsageError
from allanite.phrases.wording import spelled
from allanite.simulation.recording import readings
from allanite.statistics import Expectation, Expectations, expectation

from .channels import Source
from .modelled import demand_no_recording
from .modelling import NoiseSettings
from .recipe import Recipe
from .settings import LengthChoices
from .survey import Deviations


@dataclass(frozen=True, repr=False)
class TheorySettings(LengthChoices, NoiseSettings):
    """A model, and the length of a record for which its curves are expected: `duration` in s, or `samples`."""

    @property
    def asked(self) -> bool:
        """Whether any of it is given."""
        return self != TheorySettings()


def expected_curves(
    source: Source | None, settings: TheorySettings, wanted: Deviations, recipe: Recipe | None = None
) -> Expectation:
    """The expected curves of a model that is given instead of a recording.

    Examples
    --------
    >>> found = expected_curves(None, TheorySettings(sensor="fog"), Deviations(("oadev", "ohdev")))
    >>> [curve.statistic for curve in found.curves]
    ['oadev', 'ohdev']
    """
    recipe, model = recipe or Recipe(), settings.instead_of(source)
    if model is None:
        end = settings.duration or (settings.samples or 0) / (recipe.rate or math.inf)
        first = f"{end:g}" if end else "TIME"
        raise UsageError(
            f"{spelled('--duration and --samples are', 'duration and samples are')} the length of a record of a model; "
            f"for the beginning of a recording: {spelled(f'--until {first}', f'until={first}')}"
        )
    demand_no_recording(settings, recipe)
    if wanted.m is not None or wanted.to is not None:
        raise UsageError(
            f"{spelled('--m and --to apply', 'm and to apply')} to a recording: give averaging times in seconds, "
            + spelled("--taus 1,10,100", "taus=(1, 10, 100)")
        )
    size = None
    if settings.duration is not None or settings.samples is not None:
        if recipe.rate is None:
            raise UsageError(f"the length of a record needs its sampling rate: {spelled('--rate HZ', 'rate=...')}")
        size = readings(recipe.rate, settings.duration, settings.samples)
    tau = "log" if wanted.taus == Deviations.taus else wanted.taus
    return expectation(model, wanted.statistic, tau=tau, rate=recipe.rate, size=size, name=settings.name)


def expected_of_models(
    source: Source | None, models: Sequence[str], settings: TheorySettings, wanted: Deviations, recipe: Recipe
) -> Expectation | Expectations:
    """The expected curves of each model, or of what the settings give; the rest is that of `expected_curves`."""
    each = [replace(settings, model=model) for model in models] or [settings]
    found = tuple(expected_curves(source, one, wanted, recipe) for one in each)
    return found[0] if len(found) == 1 else Expectations(found)
