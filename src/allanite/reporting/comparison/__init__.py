"""Comparisons and pools for people and machines: text, figure, page, CSV, JSON."""
