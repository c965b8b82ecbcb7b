"""The page of devices: how meanings are computed, the grades, and the causes by device."""

from collections.abc import Iterator

from allanite.interpretation.device import REFERENCES, SCALES
from allanite.interpretation.devices import DEVICES
from generate.markdown import table

ABOUT = r"""# What a coefficient means in a sensor

Below its tables `allanite analyze` prints what the coefficients mean, in sentences computed from them. They use only identified
coefficients of a model that explains the record.

| sentence | how it is computed |
|---|---|
| white noise up to X, drift from Y on | which term is the largest in the Allan deviation, by the asymptotes: N and K are equal at $\tau = \sqrt{3}\,N/K$, N and R at $(\sqrt{2}\,N/\lvert R\rvert)^{2/3}$, N and B at $N^2 / (0.664\,B)^2$ |
| the minimum beside B | the minimum of the measured curve, over 0.664, beside the fitted B; without flicker, the minimum of the other terms, for N and K $\sqrt{2NK/\sqrt{3}}$ |
| systematic or random drift | R and K: over a record of length T the ramp changes the output by $\lvert R\rvert T$, the random walk by $K\sqrt{T}$ (1 sigma); R is larger than K in the Allan deviation beyond $\tau = 2K^2 / (3R^2)$ |
| a time constant | that of a Gauss-Markov process, or of a low-pass filter, $1/(2\pi f)$ |
| the grade of a gyroscope | its minimum in the table below |

`--device NAME` adds, for each identified term, its name in this device, its likely sources, and what to try:

```sh
allanite analyze examples/tactical_gyro.csv --device fog
```

The tables are data of the package, `al.DEVICES`; each row gives its source. They name likely causes; they prove none.
"""


def devices_page() -> Iterator[str]:
    """The page behind the index of the noise terms."""
    yield ABOUT
    yield from ("## Grades of gyroscopes", "")
    for scale in SCALES:
        rows = [(grade.name, scale.words(grade)) for grade in scale.grades]
        yield from table(("grade", scale.title), rows)
        yield from (f"Source: {scale.source}.", "")
    for device in DEVICES.values():
        title = f"{device.title[0].upper()}{device.title[1:]}"
        yield from (f"## {title}", "", f"`--device {device.name}`. {device.note}", "")
        rows = [
            (symbol, cause.name, "; ".join(cause.sources), "; ".join(cause.remedies), cause.reference)
            for symbol, cause in device.terms.items()
        ]
        yield from table(("term", "its name there", "likely sources", "what to try", "reference"), rows)
    yield from ("## References", "")
    yield from table(("cited as", "work"), REFERENCES.items())
