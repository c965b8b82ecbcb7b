"""Write examples/tactical_gyro.csv: a simulated tactical-grade gyro triad, whose truth is known.

python examples/make_sample.py [PATH]
"""

import sys
from pathlib import Path

import numpy as np

import allanite as al

RATE, SAMPLES, SEED = 10.0, 36_000, 1
TRUTH = {
    "gx": al.N(0.12, "deg/sqrt(h)") + al.B(3.0, "deg/h"),
    "gy": al.N(0.15, "deg/sqrt(h)") + al.K(40.0, "deg/h/sqrt(h)"),
    "gz": al.N(0.10, "deg/sqrt(h)") + al.B(1.5, "deg/h") + al.R(-60.0, "deg/h^2"),
}
BIAS = {"gx": 4.2, "gy": -7.9, "gz": 1.3}


def sample() -> str:
    """Text of the file."""
    rng = np.random.default_rng(SEED)
    columns = []
    for name, model in TRUTH.items():
        record = al.simulate(model, SAMPLES, RATE, rng=rng)
        columns.append(np.degrees(record.values) * 3600 + BIAS[name])
    lines = [f"# simulated tactical gyro, {RATE:g} Hz, {SAMPLES / RATE / 60:.0f} min, seed {SEED}"]
    lines += [f"# {name}: {model}, bias {BIAS[name]} deg/h" for name, model in TRUTH.items()]
    lines.append(",".join(["time [s]", *(f"{name} [deg/h]" for name in TRUTH)]))
    rows = zip(np.arange(SAMPLES) / RATE, *columns, strict=True)
    lines += [f"{t:.1f}," + ",".join(f"{value:.2f}" for value in values) for t, *values in rows]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("tactical_gyro.csv")
    path.write_text(sample(), encoding="utf-8")
