"""What processes of a batch need, loaded once by the process from which they are forked: it starts no thread."""

from importlib import import_module

import allanite.batch.job  # noqa: F401 - the task
from allanite.kernels.ahead import HERE, THERE, load
from allanite.parallel.processors import IDENTIFICATION

for name in (*IDENTIFICATION, "scipy.optimize"):
    import_module(name)
load(HERE | THERE)
