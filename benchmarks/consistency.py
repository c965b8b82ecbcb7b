"""Are exported files consistent: the error of a filter that uses them over the standard deviation that it predicts.

Records of gyros are simulated, identified as a user's would be, and exported to every target with fields, without and
with cover. Each file is read back into N, K, B and the correlation time of the bias. A Kalman filter of these takes a
measurement of the angle every second, during AIDED seconds; after it, the angle is the integral of the gyro less the
bias that was estimated. Its errors are linear in the noise of the gyro, with weights that do not depend on data: of
many filters at once they are found by one recursion, and applied to the exact covariance of the true model.
"""

from table import SEEDS, begin, coefficients, section, seeded, spread

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

import allanite as al
from allanite.core.units import unit_of
from allanite.exporting.export import exported
from allanite.exporting.fields import How
from allanite.exporting.imported import noise_in
from allanite.exporting.target import Target
from allanite.statespace.build import MarkovSum, Matrices, averaged, blocks_of, equivalent, flicker_sum, states_of
from allanite.terms.row import Block
from judge import sensor

OUTAGES = (1, 10, 60, 300, 600, 1000)  # times without aid, s
AIDED = 1000  # seconds of aid before
BEFORE = 60
"""Seconds before the aid, whose mean rate is removed from drifts without a variance, as by a calibration at rest."""
TURN_ON = 1e-2
"""Standard deviation of the bias at the start in each filter, rad/s: large, since noise does not determine it."""
AID = 0.1  # accuracy of the angle, deg

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

Array = np.ndarray
Filters = tuple[Array, Array, Array]
"""Predicted standard deviation of the angle at each outage, (filters, outages), rad, and the weights of its error: on
the mean rates while aided, oldest first, (filters, outages, AIDED), and on the errors of the measurements."""
Files = dict[tuple[str, str], al.Model | None]
"""By cover and target, the noise in its file; none if it was refused."""


@cache
def flicker() -> MarkovSum:
    """Flicker with B = 1 as Gauss-Markov processes."""
    return flicker_sum((1.0, float(OUTAGES[-1])))


def states(model: al.Model) -> tuple[list[Block], Array]:
    """The model as states at steps of 1 s, flicker as Gauss-Markov processes, and its white noise."""
    blocks = blocks_of(equivalent(model, flicker()), 1.0)
    return blocks, np.array([[sum(block.white for block in blocks)]])


def best(model: al.Model) -> Matrices:
    """The state space of a model; with a constant bias of unknown size if a term of it has no variance."""
    blocks, white = states(model)
    return averaged(states_of(blocks, 0.0 if all(map(stationary, model)) else TURN_ON, 1.0), white)


def target(model: al.Model) -> Matrices:
    """The states of a target's filter: its bias is unknown at the start; none if the target has no state for it."""
    alone = all(t.symbol == "N" for t in model)
    blocks, white = states(model + al.Term("K", 0.0, model.signal) if alone else model)
    found = averaged(states_of(blocks, 0.0, 1.0), white)
    if not alone:
        found.P0[0, 0] += TURN_ON**2
    return found


def stationary(term: al.Term) -> bool:
    """Whether the mean rate over a second has a variance."""
    return term.symbol not in ("B", "K")


def with_angle(spaces: Sequence[Matrices]) -> Array:
    """Transitions, noise and first covariances of angle and states; a space with fewer states has some that are 0."""
    size = 1 + max(len(one.Phi) for one in spaces)
    F, Q, P = made = np.zeros((3, len(spaces), size, size))
    for i, one in enumerate(spaces):
        h, inside = one.H[0], slice(1, 1 + len(one.Phi))
        F[i, 0, 0], F[i, 0, inside], F[i, inside, inside] = 1.0, h @ one.Phi, one.Phi
        Q[i, inside, inside], P[i, inside, inside] = one.Qd, one.P0
        Q[i, 0, inside] = Q[i, inside, 0] = one.Qd @ h
        Q[i, 0, 0] = h @ one.Qd @ h + one.R[0, 0]
    return made


def filters(spaces: Sequence[Matrices], accuracy: float) -> Filters:
    """Kalman filters of state spaces, with angles of an accuracy in rad."""
    F, Q, P = with_angle(spaces)
    T, shape, gains = F.transpose(0, 2, 1), (len(spaces), len(OUTAGES)), []
    for _ in range(AIDED):
        P = F @ P @ T + Q
        gains.append(P[:, :, 0] / (P[:, 0, 0] + accuracy**2)[:, None])
        P = P - gains[-1][:, :, None] * P[:, None, 0]
        P = (P + P.transpose(0, 2, 1)) / 2
    sigma, u, power = np.empty(shape), np.empty((*shape, F.shape[1])), np.broadcast_to(np.eye(F.shape[1]), F.shape)
    for t in range(1, OUTAGES[-1] + 1):
        P, power = F @ P @ T + Q, F @ power
        if t in OUTAGES:
            i = OUTAGES.index(t)
            sigma[:, i], u[:, i] = np.sqrt(P[:, 0, 0]), power[:, 0]
    aid = np.empty((*shape, AIDED))
    for k in range(AIDED - 1, -1, -1):
        aid[:, :, k] = np.einsum("rus,rs->ru", u, gains[k])
        u = u.copy()
        u[:, :, 0] -= aid[:, :, k]
        u = u @ F
    return sigma, 1 - np.cumsum(aid[:, :, ::-1], axis=2)[:, :, ::-1], -aid


def covariance(model: al.Model) -> Array:
    """Covariance of the mean rates over seconds, from the structure function of each term: AIDED, then the outage."""
    n = BEFORE + AIDED + OUTAGES[-1]
    lag = np.arange(float(n))
    index = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    C = np.zeros((n, n))
    for t in model:
        D = t.sampled(1.0).structure
        part = (t.power(1.0) * (D(lag + 1) - 2 * D(lag) + D(np.abs(lag - 1))) / 2)[index]
        if not stationary(t):
            mean = part[:BEFORE].mean(axis=0)
            part += mean[:BEFORE].mean() - mean - mean[:, None]
        C += part
    return C[BEFORE:, BEFORE:]


def errors(model: al.Model, found: Filters, accuracy: float) -> Array:
    """Standard deviations of the errors of filters under a true model, (filters, outages), rad."""
    _, past, aid = found
    ahead = np.arange(OUTAGES[-1]) < np.array(OUTAGES)[:, None]
    weights = np.concatenate([past, np.broadcast_to(ahead, (len(past), *ahead.shape))], axis=2)
    noise = np.einsum("rok,rok->ro", weights @ covariance(model), weights)
    return np.sqrt(noise + accuracy**2 * (aid**2).sum(axis=2))


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
        for name, row in ((name, row) for name, row in TARGETS.items() if asked_of(row)):
            try:
                found[cover, name] = read_back(exported(row, study, How(cover=asked, partial=True), row.form("")))
            except al.DataError:
                found[cover, name] = None
    return found


def grouped(made: dict[str, list[Files]]) -> dict[tuple[str, str], list[str]]:
    """By cover and the noise in all files: the targets whose files have it."""
    alike = defaultdict(list)
    for cover, name in next(iter(made.values()))[0]:
        alike[cover, str([[str(record[cover, name]) for record in each] for each in made.values()])].append(name)
    return alike


def judged(name: str, models: Sequence[al.Model]) -> tuple[Array, Array]:
    """Rms errors of filters at each outage, over those predicted, and over those of the best filter."""
    aid, true = math.radians(AID), SENSORS[name]
    found = filters([*map(target, models), best(true)], aid)
    error = errors(true, found, aid)
    return tuple(np.sqrt(np.mean(ratio[:-1] ** 2, axis=0)) for ratio in (error / found[0], error / error[-1]))


def rows_of(made: dict[str, list[Files]]) -> tuple[list[list[str]], list[list[str]]]:
    """Lines of both tables: least and largest of all sensors at each outage."""
    both = [], []
    for (cover, _), names in grouped(made).items():
        read = {sensor: [record[cover, names[0]] for record in records] for sensor, records in made.items()}
        kept = {sensor: [model for model in models if model] for sensor, models in read.items()}
        parts = np.array([judged(sensor, models) for sensor, models in kept.items() if models]).transpose(1, 2, 0)
        refused = sum(map(len, read.values())) - sum(map(len, kept.values()))
        for rows, part in zip(both, parts, strict=True):
            ranges = (f"{each.min():.2f} .. {each.max():.2f}" for each in part)
            rows.append([cover, ", ".join(names), *ranges, str(refused)])
    return both


def main() -> None:
    run = begin(__doc__, records=100)
    made = {name: found for (name,), found in spread(files, zip(SENSORS), run.asked.records)}
    consistency, accuracy = rows_of(made)
    notes = [
        SEEDS,
        f"records of {HOURS} h at {RATE:g} Hz, analyzed with the default recipe; {run.asked.records} a sensor",
        f"filters: angle and the biases of the file, aided for {AIDED} s by an angle every second, after the mean bias "
        f"of {BEFORE} s was removed; rms error of all records, from the covariance: least .. largest of the sensors",
        "cover: as of --cover, averaging times in s; the default of filters is from 1 s to a tenth of the record",
        *(f"{name}: {model}" for name, model in SENSORS.items()),
    ]
    heads = ("cover", "targets", *(f"{t} s" for t in OUTAGES), "refused")
    body = section(f"Consistency, aid to {AID:g} deg", heads, consistency, "Error over predicted sigma.")
    about = "Error over that of the state space of the true model."
    run.publish(
        "Consistency of exported files", notes, body + section(f"Accuracy, aid to {AID:g} deg", heads, accuracy, about)
    )


if __name__ == "__main__":
    main()
