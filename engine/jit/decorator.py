"""The one decorator of every kernel, so that all of them are compiled under the same rules."""

import os
from collections.abc import Callable, Mapping
from functools import cached_property, update_wrapper
from importlib import import_module
from importlib.util import find_spec
from typing import Generic, ParamSpec, TypeVar, cast

P = ParamSpec("P")
T = TypeVar("T")

SWITCH = "NUMBA_DISABLE_JIT"
"""Numba's own variable: with 1 in it all kernels run as Python runs them. For tests."""


def _is_off(environment: Mapping[str, str]) -> bool:
    """Whether `SWITCH` is set to a number other than 0, which is how numba reads it."""
    try:
        return int(environment.get(SWITCH, "0")) != 0
    except ValueError:
        return False


IS_OFF = _is_off(os.environ)
"""Whether kernels run as Python."""


class Kernel(Generic[P, T]):
    """A function that is compiled into those that call it; Python runs it as Python.

    `function` is the function itself. With `forceinline` its callers must contain it.
    """

    __name__: str
    __module__: str

    def __init__(self, function: Callable[P, T], *, forceinline: bool = False) -> None:
        update_wrapper(self, function)
        self.function = function
        self.forceinline = forceinline

    def __call__(self, *args: P.args, **given: P.kwargs) -> T:
        """Run it as Python."""
        return self.function(*args, **given)

    def __repr__(self) -> str:
        return f"<kernel {self.name}>"

    @property
    def name(self) -> str:
        """Where it is: `engine.exact.trace.trace_many`."""
        return f"{self.__module__}.{self.__name__}"


class EntryKernel(Kernel[P, T]):
    """A kernel by which Python enters machine code."""

    @cached_property
    def machine_code(self) -> Callable[..., T]:
        """The artifact's. If the kernels have changed since that was made, what numba compiles, or
        where there is no numba the function itself, which Python runs: slowly, with the same bits.
        """
        found = import_module("engine.jit.machine_code").entry(self)
        if found is None and find_spec("numba") is not None:
            found = import_module("engine.jit.kernel_compiler").compiled(self)
        return self.function if found is None else cast("Callable[..., T]", found)

    def __call__(self, *args: P.args, **given: P.kwargs) -> T:
        """Run its machine code."""
        return self.machine_code(*args, **given)


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile `function`, which Python calls too, so that its bits do not depend on the machine.

    No fastmath (it reorders sums and contracts a*b+c, which differs between processors), the GIL
    released (batches use threads), IEEE division. It takes numbers, arrays and named tuples of
    these, all by position.
    With NUMBA_DISABLE_JIT=1 the function itself is returned: the same bits, slower.
    """
    return function if IS_OFF else cast("Callable[P, T]", EntryKernel(function))


def inner_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`kernel` for a function that only kernels call; called from Python it runs as Python."""
    return function if IS_OFF else cast("Callable[P, T]", Kernel(function))


def lean_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`inner_kernel` that leaves the compiler no choice but to put it into its callers.

    For innermost loops: there flights take a fifth less time. In large functions with many callers
    it only costs compile time.
    """
    return function if IS_OFF else cast("Callable[P, T]", Kernel(function, forceinline=True))
