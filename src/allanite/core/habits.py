"""What other libraries call functions, arguments and attributes of results, and what it is called here."""

from collections.abc import Collection, Iterable
from numbers import Real
from typing import Any

from .errors import UsageError

CALLS = {
    "al.read(file)": "read_csv load load_csv loadtxt open read_bag from_csv from_dataframe",
    "al.identify(record)": "fit coefficients",
    "al.deviation(record)": "dev allan_deviation",
    "al.expected(model, tau)": "predict",
    "al.write(recording, path)": "save to_csv savetxt",
    "al.report(study, path)": "to_html to_pdf html",
    "al.read_noise(path, target)": "load_yaml import_noise",
}
"""A call, and the names under which it is looked for at the top level."""

SETTINGS = {
    "al.spectrum(record, al.Welch(segment=seconds))": "nperseg nfft segment window noverlap",
    "al.spectrum(record, al.Multitaper(bandwidth=NW))": "NW bandwidth tapers",
    "al.deviation(record, m=factors)": "af afs",
    "al.read(table, time=column)": "time times timestamps",
}
"""What replaces an argument of other libraries, and its names."""

REMEDIES = {
    "al.report({value}, path)": "save savefig to_html to_pdf",
    "{value}.to_dataframe().to_csv(path)": "to_csv",
    "json.dumps({value}.to_dict())": "to_json dumps",
    "{value}.alternatives, or {value}.goodness": "aic bic llf",
    "al.identify(record)": "fit identify",
    "al.deviation(record)": "oadev adev avar deviation",
    "al.spectrum(record)": "psd spectrum",
    "al.analyze(record)": "analyze",
    "al.prepare.detrend(record)": "detrend",
    "{value}.values": "shape dtype data samples to_numpy",
}
"""What replaces a method or attribute of other libraries, and its names."""

ARGUMENTS = {"fs": "rate", "sampling_rate": "rate", "dt": "rate", "seed": "rng"}
"""Arguments of other libraries, and their names here; `dt` is the inverse."""


def remedy(table: dict[str, str], name: str) -> str:
    """The entry of a table for one of its names; empty if it has none."""
    return next((text for text, names in table.items() if name in names.split()), "")


def renamed(options: dict[str, Any], names: Collection[str]) -> dict[str, Any]:
    """The options of a function with these parameters, those of `ARGUMENTS` by their names here."""
    for foreign in (ARGUMENTS.keys() & options.keys()).difference(names):
        name = ARGUMENTS[foreign]
        if name in options:
            raise UsageError(f"{name} and {foreign} are the same: give one of them")
        value = options.pop(foreign)
        options[name] = 1 / value if foreign == "dt" and isinstance(value, Real) and value else value
    return options


def demand_own(call: str, options: Iterable[str]) -> None:
    """Refuse the `SETTINGS` of other libraries."""
    for key in options:
        if here := remedy(SETTINGS, key):
            raise UsageError(f"{call} has no option {key}: use {here}")
