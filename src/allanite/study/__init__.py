"""The analyses, and the loop over the channels of a recording."""
