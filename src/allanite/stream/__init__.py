"""Streams: curves and coefficients of samples of which only sums are kept."""
