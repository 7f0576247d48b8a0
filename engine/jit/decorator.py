"""The one decorator of every kernel, so that all of them are compiled under the same rules."""

import os
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, ParamSpec, TypeVar, cast

P = ParamSpec("P")
T = TypeVar("T")

SWITCH = "NUMBA_DISABLE_JIT"
"""Numba's own variable: with 1 in it all kernels run as Python runs them."""


def _is_off(environment: Mapping[str, str]) -> bool:
    """Whether `SWITCH` is set to a number other than 0, which is how numba reads it."""
    try:
        return int(environment.get(SWITCH, "0")) != 0
    except ValueError:
        return False


IS_OFF = _is_off(os.environ)
"""Whether kernels run as Python. Numba is not imported then, which takes longer than a drop."""

_compiler: Any = None if IS_OFF else import_module("engine.jit.kernel_compiler")
_way: Any = None if IS_OFF else _compiler.choose()
_stamp = "" if IS_OFF else _compiler.source_stamp()


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile `function` so that its bits do not depend on where it runs.

    No fastmath (it reorders sums and contracts a*b+c, which differs between processors), the GIL
    released (batches use threads), machine code cached on disk beside the source, IEEE division.
    With NUMBA_DISABLE_JIT=1 the function itself is returned: the same bits, slower.
    """
    return function if IS_OFF else cast("Callable[P, T]", _way.outer(function, _stamp))


def inner_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`kernel` for a function inside of others that makes no arrays, nor calls one that does.

    Its arrays' references are not counted: numba otherwise counts them at each call, by atomic
    operations that cost more than the call. To make an array in one is an error when it is
    compiled. Nor is there machine code of its own (callers contain theirs), and so nothing to keep
    on disk and no wrapper for callers in Python: there it runs as Python runs it, with the same
    bits. That is a fifth of all compile time. Plain numba (kernel_compiler.py) does none of this.
    """
    return _inner(function, forceinline=False)


def lean_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`inner_kernel` that leaves the compiler no choice but to put it into its callers.

    For innermost loops: there flights take a fifth less time. In large functions with many callers
    it only costs compile time.
    """
    return _inner(function, forceinline=True)


def _inner(function: Callable[P, T], *, forceinline: bool) -> Callable[P, T]:
    if IS_OFF:
        return function
    return cast("Callable[P, T]", _way.inner(function, forceinline))
