"""The decorators of kernels, so that all of them are compiled with the same options."""

import os
from collections.abc import Callable, Mapping
from functools import cached_property, partial, update_wrapper
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Generic, NamedTuple, ParamSpec, TypeVar, cast

P = ParamSpec("P")
T = TypeVar("T")

SWITCH = "NUMBA_DISABLE_JIT"
"""Numba's environment variable; 1 makes all kernels run as Python. For tests."""


def _is_off(environment: Mapping[str, str]) -> bool:
    """Whether `SWITCH` is set to a number other than 0, which is how numba reads it."""
    try:
        return int(environment.get(SWITCH, "0")) != 0
    except ValueError:
        return False


IS_OFF = _is_off(os.environ)
"""Whether kernels run as Python."""


class Kernel(Generic[P, T]):
    """A function that is compiled into the kernels that call it; Python code runs it as Python.

    `function` is the undecorated function. `forceinline` makes the compiler inline it.
    """

    __name__: str
    __module__: str

    def __init__(self, function: Callable[P, T], *, forceinline: bool = False) -> None:
        update_wrapper(self, function)
        self.function = function
        self.forceinline = forceinline

    def __call__(self, *args: P.args, **given: P.kwargs) -> T:
        return self.function(*args, **given)

    def __repr__(self) -> str:
        return f"<kernel {self.name}>"

    @property
    def name(self) -> str:
        """The full name, such as `plinko.engine.exact.trace.trace_many`."""
        return f"{self.__module__}.{self.__name__}"


class EntryKernel(Kernel[P, T]):
    """A kernel that Python code calls to run machine code."""

    @cached_property
    def machine_code(self) -> Callable[..., T]:
        """The artifact's code. If the artifact is stale, numba compiles the kernel; without numba,
        Python runs the function: slowly, with the same bits.
        """
        found = import_module("plinko.engine.jit.machine_code").entry(self)
        if found is None and find_spec("numba") is not None:
            found = import_module("plinko.engine.jit.kernel_compiler").compiled(self)
        return self.function if found is None else cast("Callable[..., T]", found)

    def __call__(self, *args: P.args, **given: P.kwargs) -> T:
        return self.machine_code(*args, **given)


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile `function`, which Python code may call, to the same bits on every machine.

    Without fastmath, which reorders sums and contracts a*b+c, differently on each processor. With
    IEEE division, and with the GIL released, as batches use threads. Arguments are numbers, arrays
    and named tuples of these, by position only. With NUMBA_DISABLE_JIT=1, `function` is returned
    unchanged: the same bits, slower.
    """
    return function if IS_OFF else cast("Callable[P, T]", EntryKernel(function))


def inner_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`kernel` for a function that only kernels call; Python code runs it as Python."""
    return function if IS_OFF else cast("Callable[P, T]", Kernel(function))


def lean_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`inner_kernel` that the compiler must inline.

    For functions in innermost loops: flights take a fifth less time. For large functions with many
    callers it only costs compile time.
    """
    return function if IS_OFF else cast("Callable[P, T]", Kernel(function, forceinline=True))


class RepeatedCall(NamedTuple):
    """A call that `in_place` has prepared.

    run: run the kernel; after an exception it must not be repeated. view: the kernel's copy of one
    of the arrays, to be read and written between calls.
    """

    run: Callable[[], None]
    view: Callable[[Any], Any]


def in_place(function: Callable[P, None], *args: P.args, **given: P.kwargs) -> RepeatedCall:
    """A repeatable call of a kernel with these arguments, whose arrays are copied only here.

    The kernel must not allocate arrays.
    """
    code = function.machine_code if isinstance(function, EntryKernel) else function
    if hasattr(code, "in_place"):  # wasmtime's code, which has a memory of its own
        machine = code.in_place(args)
        return RepeatedCall(machine.repeat, machine.view)
    return RepeatedCall(partial(code, *args), lambda array: array)
