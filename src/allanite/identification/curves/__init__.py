"""Methods that fit a curve."""
