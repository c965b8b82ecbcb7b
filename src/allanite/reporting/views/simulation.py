"""How the truth of a simulated recording is shown."""

from allanite.phrases.phrase import say
from allanite.reporting import words
from allanite.reporting.sheet import Face, Sheet, toml

from . import View
from .fit import model_table

SIMULATION = View(
    lambda simulation, _: Face(
        say("Simulation of {model}", model=str(simulation.model)),
        say("a recording whose noise is known"),
        [Sheet(c.name, (words.about(c), *c.history)) for c in simulation.channels],
        close=(model_table(simulation.model),),
        choices=toml({"seed": simulation.seed}),
    )
)
