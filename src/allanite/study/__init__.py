"""The analyzes, and the loop over the channels of a recording."""
