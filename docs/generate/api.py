"""The Python reference: every public name, by topic."""

from collections.abc import Iterable, Iterator, Mapping
from operator import attrgetter
from types import ModuleType

import allanite as al
from allanite.terms import TERMS
from generate.markdown import table

TOPICS: dict[str, tuple[str, str]] = {
    "reading": (
        "Recordings: read, write, values",
        "read write Record Recording from_dict",
    ),
    "preparing": ("Preparing a record", "prepare"),
    "identifying": (
        "Identification of noise",
        "identify residuals whitened shared Fit Estimate identification",
    ),
    "curves": (
        "Allan deviation and other statistics",
        "deviation dynamic expected readings minimum averaging_stability statistics Curve",
    ),
    "streaming": ("Streams", "Accumulator"),
    "spectra": ("Power spectral density", "spectrum deviation_of_spectrum Welch Multitaper Spectrum"),
    "models": ("Models of noise", f"{' '.join(TERMS)} Term Model sensor"),
    "simulating": ("Simulation and faults", "simulate simulation simulation.faults"),
    "planning": (
        "Planning, self-check, Kalman filter",
        "plan bound selfcheck state_space StateSpace planning",
    ),
    "analyzing": (
        "Analysis, figures and reports",
        "analyze Recipe Study plot report batch interpretation",
    ),
    "exporting": ("Files for filters and simulators", "export read_noise Export exporting"),
    "claims": ("Claims and drift", "check drift Drift claims"),
    "comparing": ("Comparison", "compare Comparison comparison"),
    "compensating": ("Temperature compensation", "compensate compensation"),
    "quantizing": ("Quantization budget and torquer currents", "signals"),
    "rate": ("A constant rate in a short time", "constant_rate"),
    "angle": ("Angle sensors", "angle"),
    "attitude": ("Roll and pitch", "attitude"),
    "checking": ("Checks of plug-ins", "testing"),
    "errors": ("Errors", "AllaniteError DataError UnitError UsageError"),
}
"""A page: its title, and the names that it describes. A package means all its public names."""

INNER = {
    "statistics": ("edf", "expectation", "Expectation", "covariance", "integrated", "Surface", "LongJobWarning"),
    "identification": ("Residuals", "Shared"),
    "signals": ("budget", "budget_file", "rate_from_current", "Budget", "PathSettings", "Stage", "TorqueScale"),
}
"""Packages of which only these names are for users; of the others, whatever is not a module."""

WITHOUT = {"terms"}  # packages of which only the table is for users


def api_pages() -> Iterator[tuple[str, list[str]]]:
    """Name and lines of every page, the index last."""
    _demand_all()
    for page, (title, names) in TOPICS.items():
        yield page, _page(title, names.split())
    yield "index", _index()


def public_names(package: str) -> list[str]:
    """What a package offers, its modules left out."""
    module = attrgetter(package)(al)
    names = INNER.get(package) or [name for name in dir(module) if _is_public(module, name)]
    return sorted(names, key=lambda name: (isinstance(getattr(module, name), type), name))


def _is_public(module: ModuleType, name: str) -> bool:
    thing = getattr(module, name)
    own = getattr(thing, "__module__", "").startswith("allanite.") and name not in dir(al)
    return not name.startswith("_") and own and callable(thing)


def _demand_all() -> None:
    """Make sure that every public name has its place."""
    placed = [name for _, names in TOPICS.values() for name in names.split() if "." not in name]
    wanted = {name for name in dir(al) if not name.startswith("_")} - WITHOUT | {*TERMS}
    if sorted(placed) != sorted(wanted):
        raise ValueError(f"topics of the Python reference: {sorted(wanted ^ set(placed))} to be placed or taken out")


def _page(title: str, names: Iterable[str]) -> list[str]:
    lines = [f"# {title}", ""]
    for name in names:
        thing = attrgetter(name)(al)
        if isinstance(thing, ModuleType):
            lines += [f"## `al.{name}`", "", (thing.__doc__ or "").split("\n\n")[0], ""]
            lines += [line for inner in public_names(name) for line in _directive(f"{name}.{inner}", thing, inner)]
        else:
            lines += _directive(name, al, name)
    return lines


def _directive(path: str, module: ModuleType, name: str) -> list[str]:
    thing = getattr(module, name)
    error = isinstance(thing, type) and issubclass(thing, Exception)
    kind = "autoclass" if isinstance(thing, type) else "autofunction"
    option = "   :show-inheritance:" if error else "   :members:" if kind == "autoclass" else ""
    return ["```{eval-rst}", f".. {kind}:: allanite.{path}", *([option] if option else []), "```", ""]


def _index() -> list[str]:
    rows = []
    for page, (title, names) in TOPICS.items():
        every = [
            f"`{name}.{inner}`" if package else f"`{name}`"
            for name in names.split()
            for package in [isinstance(attrgetter(name)(al), ModuleType)]
            for inner in (public_names(name) if package else [""])
        ]
        rows.append((f"[{title}]({page}.md)", ", ".join(every)))
    rooms = {name: thing for name in dir(al) if isinstance(thing := getattr(al, name), ModuleType)}
    every = ((f"{room}.{name}", getattr(thing, name)) for room, thing in rooms.items() for name in dir(thing))
    tables = sorted(path for path, value in every if isinstance(value, Mapping) and path.rpartition(".")[2].isupper())
    return [
        "# Python", "",
        "`import allanite as al`. Values are frozen and are passed through plain functions; everything inside is SI.",
        "",
        *table(("topic", "names"), rows),
        f"Tables, by name: {', '.join(f'`al.{name}`' for name in tables)}.", "",
        "```{toctree}", ":hidden:", "", *TOPICS, "```",
    ]  # fmt: skip
