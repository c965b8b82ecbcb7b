"""How the truth of a simulated recording is shown."""

from allanite.phrases.phrase import say
from allanite.reporting import words
from allanite.reporting.sheet import Face, Sheet, toml
from allanite.simulation.recording import Simulation

from . import View
from .fit import model_table


def _face(simulation: Simulation, _: float) -> Face:
    sheets = [Sheet(c.name, (words.about(c), *c.history)) for c in simulation.channels]
    return Face(
        say("Simulation of {model}", model=str(simulation.model)), say("a recording whose noise is known"), sheets,
        close=(model_table(simulation.model),), choices=toml({"seed": simulation.seed}),
    )  # fmt: skip


SIMULATION = View(_face)
