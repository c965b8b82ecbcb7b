"""How kernels are compiled: each decorator stands once.

Sums of `swift` kernels may be reordered, so that they use SIMD; NaN and infinity keep their meaning.

A kernel that another one calls is compiled twice: by itself, and once more within its caller. Which of the two codes
runs depends on which was loaded first, and in reordered sums they differ in the last digit. So a kernel with such sums,
its own or those of a kernel that it calls, is a part if another kernel calls it: parts are inlined, and what a caller
computes does not depend on what was compiled or loaded before (tests/conformance/test_kernels.py).

Most of the time of compiling goes into types and wrappers, not into loops. What only kernels call, `inner` and parts,
has no wrapper for Python: called from there it ends the process. What Python calls as well is `shared`. What one kernel
calls at one place is `once`: it is put there before types are inferred, and its sums are reordered if its caller's are.
An array expression, an assignment to a slice or a function of numpy brings code for every shape and error with it: in
kernels that a first run compiles, loops are written instead (docs/architecture.md).
"""

from contextlib import suppress
from functools import partial

from numba import njit
from numba.core.caching import FunctionCache
from numba.core.entrypoints import init_all

with suppress(Exception):  # the malformed metadata of some package; numba looks for its own plug-ins once
    init_all()  # type: ignore[no-untyped-call]


def _kept() -> bool:
    try:
        FunctionCache(_kept)  # type: ignore[no-untyped-call]  # numba has no types
    except RuntimeError:  # no folder of a cache can be written
        return False
    return True


KEPT = _kept()
"""Whether compiled code is kept for the next process: in NUMBA_CACHE_DIR, beside the source or in the home folder."""

_numba = partial(njit, cache=KEPT, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
_inner = partial(_numba, no_cpython_wrapper=True)
_swift = partial(_numba, fastmath={"reassoc", "nsz", "contract"})

kernel = _numba()
inner = _inner()
shared = _numba(forceinline=True)
part = _inner(forceinline=True)
once = _inner(cache=False, inline="always")
swift = _swift()
swift_shared = _swift(forceinline=True)
swift_part = _swift(forceinline=True, no_cpython_wrapper=True)
