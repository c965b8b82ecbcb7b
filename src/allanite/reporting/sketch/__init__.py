"""Figures of a page as SVG, written at once: the part of matplotlib's interface that they use, and nothing else.

A figure of matplotlib takes a tenth of a second for the objects of its ticks, its layout and its writer. What is made
here takes a few milliseconds. What is missing raises `Unsketched`, and matplotlib draws the figure.
"""
