"""Which terms are claimed: false ones, upper limits of absent ones, goodness of fit, flicker against Gauss-Markov.

Records at 100 Hz are simulated with seeds 1, 2, 3, ... and identified as a user would.
"""

from table import begin, markdown, shared

import math
from dataclasses import dataclass, replace
from multiprocessing import Pool

import numpy as np

import allanite as al
from allanite.identification.likelihood.law import Subset, ThetaProfile
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import likelihood
from identification import RATE, SENSORS, bounds

N, K, MEMS = al.N(0.005, "deg/sqrt(s)"), al.K(3e-4, "deg/s/sqrt(s)"), SENSORS["MEMS"]
HEADINGS = ("what", "model", "n", "value", "demand")


@dataclass(frozen=True)
class Case:
    """Records of a model, and what is asked of each."""

    name: str
    model: al.Model
    n: int


PURE = [
    Case("N", al.Model((N,)), 2**16),
    Case("N K", N + K, 2**16),
    Case("Q N", al.Q(0.5, "arcsec") + al.N(0.18, "arcsec/sqrt(s)"), 2**16),
]
WHOLE = [Case(name, model, 2**18) for name, model in SENSORS.items()]
LIMITED = "RLG"
STEPS = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0)
MARKOV = [
    Case("N B K", MEMS, 2**18),
    Case("N GM(20 s)", N + al.GM(0.004, "deg/s", time_constant=20.0), 2**18),
    Case("N GM(5 s) K", N + al.GM(0.002, "deg/s", time_constant=5.0) + K, 2**18),
    Case("N GM(60 s) K", N + al.GM(0.002, "deg/s", time_constant=60.0) + K, 2**18),
]


def fitted(job: tuple[Case, int]) -> tuple[dict[str, tuple[str, float, float]], float, float]:
    """Status, value and upper limit of each term, goodness of fit p, and the time constant or 0."""
    case, seed = job
    fit = al.identify(al.simulate(case.model, case.n, RATE, rng=np.random.default_rng(seed)))
    terms = {e.symbol: (e.status, e.value or 0.0, math.nan if e.upper is None else e.upper) for e in fit}
    return (
        terms,
        fit.goodness.p if fit.goodness else math.nan,
        fit["GM"].shape[0] if "GM" in terms and fit["GM"].shape else 0.0,
    )


def claimed(terms: dict[str, tuple[str, float, float]]) -> set[str]:
    """Symbols of the terms that are said to be there."""
    return {s for s, (status, _, _) in terms.items() if status in ("identified", "weak")}


def percent(hits: list[bool]) -> str:
    """A share with its standard error."""
    return f"{shared(hits)} %"


def variance_error(model: al.Model, symbol: str, n: int) -> float:
    """Cramer-Rao bound of theta (SI squared) of a term that is absent, as where it is next to nothing."""
    tiny = al.Term(symbol, 1e-6 * math.sqrt(model.terms[-1].value ** 2), model.signal)
    return 2 * bounds(al.Model((*model.terms, tiny)), n)[symbol] * tiny.value**2


def expected_limit(model: al.Model, symbol: str, n: int) -> float:
    """One-sided 95 % limit of an absent term where every power is what is expected, and the true terms are known."""
    seen = spectrum(al.simulate(model, n, RATE, rng=np.random.default_rng(1)), detrend=False)
    ours = likelihood(seen, [*(t.symbol for t in model), symbol])
    theta = np.array([*((t.value * RATE**t.row.power) ** 2 for t in model), 0.0])
    edges = np.einsum("bii,i->b", ours.UU, ours.W @ theta) / ours.count
    ours = replace(ours, power=ours.expectation(theta) + edges, Uc=np.zeros_like(ours.Uc))
    free = np.ones(theta.size, dtype=bool)
    upper = ThetaProfile(Subset(ours, free, *ours.minimise(free)), theta.size - 1).upper(2.706)
    return math.sqrt(upper) * RATE ** -al.terms.TERMS[symbol].power


def with_walk(steps: float, n: int) -> Case:
    """The ring laser with a random walk of so many standard errors of K^2."""
    model = SENSORS[LIMITED]
    K2 = steps * variance_error(model, "K", n)
    walk = (al.Term("K", math.sqrt(K2), model.signal),) if steps else ()
    return Case(f"{LIMITED}, K² = {steps:g} se", al.Model((*model.terms, *walk)), n)


def rows(records: int, pool: "Pool") -> list[tuple[str, ...]]:
    """The table."""

    def made(case: Case) -> list:
        return pool.map(fitted, [(case, seed) for seed in range(1, records + 1)], chunksize=5)

    found = []
    for case in PURE:
        true = {t.symbol for t in case.model}
        seen = made(case)
        false = [claimed(t) - true for t, _, _ in seen]
        noise, ramp = percent([bool(f - {"R"}) for f in false]), percent(["R" in f for f in false])
        found.append(("any false noise term claimed", case.name, case.n, noise, "<= 7 %"))
        found.append(("a false ramp claimed", case.name, case.n, ramp, "<= 8 %"))
    for case in WHOLE:
        seen = made(case)
        found.append(
            ("goodness of fit p < 5 %", case.name, case.n, percent([p < 0.05 for _, p, _ in seen]), "3 .. 8 %")
        )
    for steps in STEPS:
        case = with_walk(steps, 2**18)
        K2 = steps * variance_error(SENSORS[LIMITED], "K", case.n)
        seen = [t["K"][2] for t, _, _ in made(case)]
        found.append(("upper limit of K holds", case.name, case.n, percent([u**2 >= K2 for u in seen]), ">= 91 %"))
        if steps == 0:
            expected = expected_limit(SENSORS[LIMITED], "K", case.n)
            ratio = f"{np.median(seen) / expected:.2f}"
            found.append(("median limit over the expected one", case.name, case.n, ratio, "<= 1.5"))
    for case in MARKOV:
        seen, wanted = made(case), "GM" if "GM" in case.name else "B"
        found.append((f"{wanted} claimed", case.name, case.n, percent([wanted in claimed(t) for t, _, _ in seen]), ""))
        other = "B" if wanted == "GM" else "GM"
        found.append((f"{other} claimed", case.name, case.n, percent([other in claimed(t) for t, _, _ in seen]), ""))
        constants = [T for _, _, T in seen if T]
        if wanted == "GM" and constants:
            middle, spread = np.median(constants), np.std(np.log(constants))
            text = f"{middle:.3g} s, scatter {100 * spread:.0f} %"
            found.append(("time constant where claimed", case.name, case.n, text, ""))
    return [tuple(map(str, row)) for row in found]


def main() -> None:
    run = begin(__doc__, records=1000)
    with Pool() as pool:
        table = rows(run.asked.records, pool)
    notes = [
        f"seeds 1..{run.asked.records}; 100 Hz; se: standard error of K² by the Cramer-Rao bound; the expected limit "
        "is that of a spectrum in which every power is what is expected, the true terms known"
    ]
    run.publish("Which terms are claimed", notes, markdown(HEADINGS, table))


if __name__ == "__main__":
    main()
