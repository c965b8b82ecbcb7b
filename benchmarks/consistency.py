"""Are exported files consistent: the error of a filter that uses them over the standard deviation that it predicts.

Records of gyros are simulated, identified as a user's would be, and exported to every target with fields, without and
with cover. Each file is read back into N, K, B and the correlation time of the bias, and a Kalman filter of these,
which is aided by an angle every second and then left alone, meets noise of the true model. With ALLANITE_RECORDINGS,
the folder of the recordings, the models that are identified in the ADIS16405 among them are true models, too.
"""

from table import begin, section

import math
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import aided
import allanite as al
from aided import AIDED, OUTAGES, Array
from allanite.core.units import unit_of
from allanite.exporting.export import exported
from allanite.exporting.fields import How
from allanite.exporting.imported import noise_in
from allanite.exporting.target import Target

HOURS, RATE = 6, 10.0
N = al.N(0.3, "deg/sqrt(h)")
SENSORS = {
    "N B": N + al.B(7.2, "deg/h"),
    "N GM": N + al.GM(10, "deg/h", time_constant=200.0),
    "N B K": N + al.B(7.2, "deg/h") + al.K(20, "deg/h/sqrt(h)"),
    "N B GM": N + al.B(5, "deg/h") + al.GM(10, "deg/h", time_constant=100.0),
}
RECORDED = al.Recipe(unit="deg/s", channels=("1", "2", "3"))
TARGETS = {name: row for name, row in al.exporting.EXPORTS.items() if row.fields}
COVERS: dict[str, tuple[object, Callable[[Target], bool]]] = {
    "no": (False, lambda row: True),
    "default": (None, lambda row: True),
    "1,100": ((1.0, 100.0), lambda row: row.drifts and not row.simulates),
    "1,1000": ((1.0, 1000.0), lambda row: row.drifts),
}
"""What is asked of an export, and of which targets."""

HEADINGS = ("sensor", "cover", "targets", "median model", "refused", *(f"{t} s" for t in OUTAGES))
PARTS = (
    (
        "Consistency",
        "Rms error over predicted sigma, of all records (lowest .. highest of a record), from the covariance.",
        ["simulated / exact"],
    ),
    ("Accuracy", "Rms error over that of the state space of the true model / median of the predicted sigma, deg.", []),
)


def read_back(found: al.Export) -> al.Model:
    """The noise of the gyro in a file: with a correlation time, its bias is a Gauss-Markov process."""
    row = al.exporting.EXPORTS[found.target]
    model = noise_in(found.text, row, RATE).gyro
    assert model is not None  # noqa: S101 - every target has a field for N
    times = [e.values[0] * unit_of(e.unit).factor for e in found.entries if e.formula == "T"]
    if not times or not any(t.symbol == "K" for t in model):
        return model
    T = times[0]
    walk = al.Term("GM", model["K"].value * math.sqrt(T / 2), model.signal, (T,))
    return al.Model(tuple(walk if t.symbol == "K" else t for t in model))


def studies(model: al.Model, seed: int, records: int) -> Iterator[al.Study]:
    """Records of a model, analyzed as a user's."""
    for i in range(records):
        rng = np.random.default_rng((seed, i))
        yield al.analyze(al.simulate(model, duration=HOURS * 3600, rate=RATE, rng=rng, name="gx"))


def recorded() -> Iterator[tuple[str, al.Model]]:
    """The models of the gyros in the recordings of an ADIS16405, if the folder is known."""
    folder = os.environ.get("ALLANITE_RECORDINGS")
    for i in (1, 2, 3) if folder else ():
        for channel in al.analyze(Path(str(folder), f"adis_16405_imu{i}.rda"), RECORDED).channels:
            if channel.noise and channel.noise.fit.valid:
                yield f"ADIS16405 {i}{channel.record.name[-1]}", channel.noise.fit.valid


@dataclass(frozen=True, eq=False)
class Group:
    """Targets whose files have the same noise: the models of the records, and how many were refused."""

    targets: tuple[str, ...]
    models: tuple[al.Model, ...]
    refused: int


def grouped(analyzed: Sequence[al.Study], word: str) -> list[Group]:
    """The targets by the noise in their files."""
    groups: dict[tuple[str, ...], list[str]] = defaultdict(list)
    kept: dict[tuple[str, ...], list[al.Model]] = {}
    cover, asked_of = COVERS[word]
    for name, row in ((name, row) for name, row in TARGETS.items() if asked_of(row)):
        models = []
        for study in analyzed:
            try:
                models.append(read_back(exported(row, study, How(cover=cover, partial=True), row.form(""))))
            except al.DataError:
                continue
        key = tuple(map(str, models))
        groups[key].append(name)
        kept[key] = models
    return [Group(tuple(names), tuple(kept[key]), len(analyzed) - len(key)) for key, names in groups.items() if key]


@dataclass(frozen=True, eq=False)
class Sensor:
    """A true model: its moments, simulated noise, and the unit errors of the aid."""

    model: al.Model
    truth: aided.Truth
    past: Array
    angles: Array
    jitter: Array

    @classmethod
    def of(cls, model: al.Model, runs: int, rng: np.random.Generator) -> "Sensor":
        """With so many runs."""
        return cls(model, aided.truth(model), *aided.noise(model, runs, rng), rng.standard_normal((runs, AIDED)))

    def judged(self, group: Group, aid: float) -> tuple[list[list[str]], float]:
        """Cells of both tables with an aid to so many rad, and how many of its errors the simulation is off at most."""
        found = aided.filters([aided.target(model) for model in group.models], aid)
        error = self.truth.errors(found, aid)
        ratio, best = error / found.sigma, self.truth.errors(aided.filters([aided.best(self.model)], aid), aid)
        square = np.zeros(len(OUTAGES))
        for past, jitter, sigma in zip(found.past, found.aid, found.sigma, strict=True):
            runs = self.angles + self.past @ past.T + (aid * self.jitter @ jitter.T if aid else 0.0)
            square += np.mean((runs / sigma) ** 2, axis=0) / len(found.sigma)
        off = np.sqrt(square) / rms(ratio)
        columns = (rms(ratio), ratio.min(axis=0), ratio.max(axis=0))
        consistency = [f"{every:.2f} ({low:.2f} .. {high:.2f})" for every, low, high in zip(*columns, strict=True)]
        widths = np.degrees(np.median(found.sigma, axis=0))
        accuracy = [f"{over:.2f} / {width:.3g}" for over, width in zip(rms(error / best), widths, strict=True)]
        most = float(np.abs(off - 1).max() * math.sqrt(2 * len(self.past)))
        return [[*consistency, f"{off.min():.2f} .. {off.max():.2f}"], accuracy], most


def rms(x: Array) -> Array:
    """Over the first axis."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def middle(models: Sequence[al.Model]) -> str:
    """The median of each coefficient, and of the correlation time."""
    sizes: dict[str, list[float]] = defaultdict(list)
    for model in models:
        for t in model:
            K = t.symbol == "GM"
            sizes["K" if K else t.symbol].append(t.value * (math.sqrt(2 / t.shape[0]) if K else 1.0))
            if K:
                sizes["T"].append(t.shape[0])
    words = {k: str(al.Term(k, float(np.median(v)), models[0].signal)) for k, v in sizes.items() if k != "T"}
    return ", ".join([*words.values(), *(f"T = {np.median(v):.3g} s" for k, v in sizes.items() if k == "T")])


def main() -> None:
    """Make the table."""
    choices = {"sensors": list(SENSORS), "covers": list(COVERS)}
    run = begin(__doc__, records=100, recorded=4, runs=1000, aids=[0.1, 0.0], **choices)
    asked = run.asked
    truths = {name: (SENSORS[name], asked.records) for name in asked.sensors}
    truths |= {name: (model, asked.recorded) for name, model in recorded()}
    pages: dict[float, tuple[list[list[str]], ...]] = {aid: ([], []) for aid in asked.aids}
    furthest = 0.0
    for seed, (name, (model, records)) in enumerate(truths.items()):
        analyzed = list(studies(model, seed, records))
        groups = [(word, group) for word in asked.covers for group in grouped(analyzed, word)]
        sensor = Sensor.of(model, asked.runs, np.random.default_rng((seed, records)))
        for cover, group in groups:
            start = [name, cover, ", ".join(group.targets), middle(group.models), str(group.refused)]
            for aid, both in pages.items():
                made, off = sensor.judged(group, math.radians(aid))
                furthest = max(furthest, off)
                for rows, ends in zip(both, made, strict=True):
                    rows.append(start + ends)
        print(name, len(groups), file=sys.stderr, flush=True)
    sensors = [f"{name}: {model}" for name, (model, _) in truths.items()]
    notes = [
        "seeds: number of the sensor, number of the record; of what filters meet: number of the sensor, of records",
        f"records of {HOURS} h at {RATE:g} Hz, analyzed with the default recipe; {asked.records} a sensor, "
        f"{asked.recorded} of each model found in a recording",
        f"filters: angle and the biases of the file, aided for {AIDED} s by an angle every second, after the mean bias "
        f"of {aided.BEFORE} s was removed",
        "cover: as of --cover, averaging times in s; the default of filters is from 1 s to a tenth of the record",
        f"simulated: {asked.runs} runs; of all figures the one furthest from the covariance is {furthest:.1f} of its "
        "standard errors off",
        *sensors,
    ]
    body = []
    for aid, both in pages.items():
        for part, rows in zip(PARTS, both, strict=True):
            title, about, more = part
            body += section(f"{title}, aid to {aid:g} deg", [*HEADINGS, *more], rows, about)
    run.publish("Consistency of exported files", notes, body)


if __name__ == "__main__":
    main()
