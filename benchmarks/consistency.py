"""Are exported files consistent: the error of a filter that uses them over the standard deviation that it predicts.

Records of gyros are simulated, identified as a user's would be, and exported to every target with fields, without and
with cover. Each file is read back into N, K, B and the correlation time of the bias, and a Kalman filter of these,
which is aided by an angle every second and then left alone, meets noise of the true model.
"""

from table import SEEDS, begin, coefficients, section, seeded, spread

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

import aided
import allanite as al
from aided import AIDED, OUTAGES, Array
from allanite.core.units import unit_of
from allanite.exporting.export import exported
from allanite.exporting.fields import How
from allanite.exporting.imported import noise_in
from allanite.exporting.target import Target
from judge import sensor

HOURS, RATE = 6, 10.0
SENSORS = {
    "N B": al.Model("N 0.3 deg/sqrt(h), B 7.2 deg/h"),
    "N GM": al.Model("N 0.3 deg/sqrt(h), GM 10 deg/h 200 s"),
    "N B K": al.Model("N 0.3 deg/sqrt(h), B 7.2 deg/h, K 20 deg/h/sqrt(h)"),
    "N B GM": al.Model("N 0.3 deg/sqrt(h), B 5 deg/h, GM 10 deg/h 100 s"),
}
TARGETS = {name: row for name, row in al.exporting.EXPORTS.items() if row.fields}
COVERS: dict[str, tuple[object, Callable[[Target], bool]]] = {
    "no": (False, lambda row: True),
    "default": (None, lambda row: True),
    "1,100": ((1.0, 100.0), lambda row: row.drifts and not row.simulates),
    "1,1000": ((1.0, 1000.0), lambda row: row.drifts),
}
"""What is asked of an export, and of which targets."""

Files = dict[tuple[str, str], al.Model | None]
"""By cover and target, the noise in its file; none if it was refused."""


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


def files(job: tuple[str, int]) -> Files:
    """What the files of a record say, which is analyzed as a user's."""
    name, number = job
    y = sensor(round(HOURS * 3600 * RATE), RATE, seeded(number, name), **coefficients(SENSORS[name]))
    study, found = al.analyze(al.Record(y, RATE, "rad/s", name="gx")), {}
    for cover, (asked, asked_of) in COVERS.items():
        for target, row in ((target, row) for target, row in TARGETS.items() if asked_of(row)):
            try:
                export = exported(row, study, How(cover=asked, partial=True), row.form(""))
            except al.DataError:
                found[cover, target] = None
            else:
                found[cover, target] = read_back(export)
    return found


@dataclass(frozen=True, eq=False)
class Truth:
    """A true model: its moments, simulated noise, and the unit errors of the aid."""

    model: al.Model
    moments: aided.Truth
    past: Array
    angles: Array
    jitter: Array

    @classmethod
    def of(cls, name: str, runs: int) -> "Truth":
        """With so many runs."""
        model, rng = SENSORS[name], seeded(0, "truth", name)
        return cls(model, aided.truth(model), *aided.noise(model, runs, rng), rng.standard_normal((runs, AIDED)))

    def judge(self, models: Sequence[al.Model], aid: float) -> tuple[Array, Array, float]:
        """At each outage, of filters aided to so many rad: errors over those predicted, rms errors over the best.

        The last is by how many of its standard errors a simulated figure is off at most.
        """
        filters = aided.filters([aided.target(model) for model in models], aid)
        error = self.moments.errors(filters, aid)
        best = self.moments.errors(aided.filters([aided.best(self.model)], aid), aid)
        square = np.zeros(len(OUTAGES))
        for past, jitter, sigma in zip(filters.past, filters.aid, filters.sigma, strict=True):
            runs = self.angles + self.past @ past.T + (aid * self.jitter @ jitter.T if aid else 0.0)
            square += np.mean((runs / sigma) ** 2, axis=0) / len(filters.sigma)
        ratio = error / filters.sigma
        off = np.abs(np.sqrt(square) / rms(ratio) - 1).max() * math.sqrt(2 * len(self.past))
        return ratio, rms(error / best), float(off)


def rms(x: Array) -> Array:
    """Over the first axis."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def grouped(made: dict[str, list[Files]]) -> dict[tuple[str, tuple[str, ...]], dict[str, list[al.Model]]]:
    """By cover and targets whose files have the same noise: the models in the files of each sensor."""
    alike: dict[tuple[str, str], list[str]] = defaultdict(list)
    for cover, target in next(iter(made.values()))[0]:
        noise = [[str(record[cover, target]) for record in records] for records in made.values()]
        alike[cover, str(noise)].append(target)
    return {
        (cover, tuple(targets)): {
            name: [model for record in records if (model := record[cover, targets[0]])]
            for name, records in made.items()
        }
        for (cover, _), targets in alike.items()
    }


def rows_of(start: list[str], judged: dict[str, tuple[Array, Array, float]], refused: int) -> tuple[list[str], ...]:
    """Lines of both tables: least and largest of all sensors at each outage, and the sensor and time at worst."""
    ratios = {name: rms(ratio) for name, (ratio, *_) in judged.items()}
    name, i = max(((name, i) for name in ratios for i in range(len(OUTAGES))), key=lambda at: ratios[at[0]][at[1]])
    column = judged[name][0][:, i]
    worst = f"{ratios[name][i]:.2f} ({column.min():.2f} .. {column.max():.2f}), {name}, {OUTAGES[i]} s"
    ranges = [
        [f"{low:.2f} .. {high:.2f}" for low, high in zip(np.min(part, axis=0), np.max(part, axis=0), strict=True)]
        for part in (list(ratios.values()), [over for _, over, _ in judged.values()])
    ]
    return [*start, *ranges[0], worst, str(refused)], [*start, *ranges[1]]


def main() -> None:
    """Make the table."""
    run = begin(__doc__, records=100, runs=1000, aids=[0.1, 0.0], sensors=list(SENSORS))
    asked, made = run.asked, {}
    for (name,), records in spread(files, [(name,) for name in asked.sensors], asked.records):
        made[name] = records
    truths = {name: Truth.of(name, asked.runs) for name in made}
    pages: dict[float, tuple[list[list[str]], ...]] = {aid: ([], []) for aid in asked.aids}
    furthest = 0.0
    for (cover, targets), models in grouped(made).items():
        refused = asked.records * len(made) - sum(map(len, models.values()))
        for aid, both in pages.items():
            judged = {name: truths[name].judge(each, math.radians(aid)) for name, each in models.items() if each}
            furthest = max([furthest, *(off for *_, off in judged.values())])
            for rows, row in zip(both, rows_of([cover, ", ".join(targets)], judged, refused), strict=True):
                rows.append(row)
    notes = [
        SEEDS,
        f"records of {HOURS} h at {RATE:g} Hz, analyzed with the default recipe; {asked.records} a sensor",
        f"filters: angle and the biases of the file, aided for {AIDED} s by an angle every second, after the mean bias "
        f"of {aided.BEFORE} s was removed",
        "cover: as of --cover, averaging times in s; the default of filters is from 1 s to a tenth of the record",
        f"simulated: {asked.runs} runs; of all figures the one furthest from the covariance is {furthest:.1f} of its "
        "standard errors off",
        *(f"{name}: {SENSORS[name]}" for name in made),
    ]
    heads, body = ("cover", "targets", *(f"{t} s" for t in OUTAGES)), []
    for aid, (consistency, accuracy) in pages.items():
        body += section(
            f"Consistency, aid to {aid:g} deg", (*heads, "worst", "refused"), consistency,
            "Rms error over predicted sigma, of all records, from the covariance: least .. largest of the sensors. "
            "Worst: lowest .. highest of a record, sensor and time.",
        )  # fmt: skip
        body += section(
            f"Accuracy, aid to {aid:g} deg", heads, accuracy,
            "Rms error over that of the state space of the true model: least .. largest of the sensors.",
        )  # fmt: skip
    run.publish("Consistency of exported files", notes, body)


if __name__ == "__main__":
    main()
