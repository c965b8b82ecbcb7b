"""Degrees of freedom, limits and biases."""
