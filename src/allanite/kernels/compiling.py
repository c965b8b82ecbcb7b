"""How kernels are compiled: each decorator stands once.

Sums of `swift` kernels may be reordered, so that they use SIMD; NaN and infinity keep their meaning.

A kernel that another one calls is compiled twice: by itself, and once more within its caller. Which of the two codes
runs depends on which was loaded first, and in reordered sums they differ in the last digit. So a kernel with such sums,
its own or those of a kernel that it calls, is a part if another kernel calls it: parts are inlined, and what a caller
computes does not depend on what was compiled or loaded before (tests/conformance/test_kernels.py).
"""

from numba import njit

FAST = {"reassoc", "nsz", "contract"}

kernel = njit(cache=True, nogil=True)
part = njit(cache=True, nogil=True, forceinline=True)
swift = njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
swift_part = njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST, forceinline=True)
