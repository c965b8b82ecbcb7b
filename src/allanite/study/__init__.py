"""The jobs, and the one loop over the channels of a recording."""
