"""The one decorator of every kernel, so that all of them are compiled under the same rules."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

from numba import njit

P = ParamSpec("P")
T = TypeVar("T")


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile `function` so that its bits do not depend on where it runs.

    No fastmath (it reorders sums and contracts a*b+c, which differs between processors), the GIL
    released (batches use threads), machine code cached on disk beside the source, and IEEE
    division. With NUMBA_DISABLE_JIT=1 the function itself is returned: the same bits, slower.
    """
    compile_it = njit(cache=True, nogil=True, fastmath=False, error_model="numpy")
    return cast("Callable[P, T]", compile_it(function))
