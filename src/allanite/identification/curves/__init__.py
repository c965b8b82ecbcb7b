"""Coefficients read off a curve."""
