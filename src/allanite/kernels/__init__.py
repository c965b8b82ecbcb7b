"""Compiled inner loops: contiguous arrays and integers in, arrays out; no checks, no units, no values.

Slices are taken before the loops, so that no index needs a sign test and the compiler can use SIMD; sums are kept per
block and then added, which also keeps rounding errors from growing with the length.
"""
