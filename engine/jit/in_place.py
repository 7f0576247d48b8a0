"""Repeated calls of a kernel on the same arrays, which are copied only once."""

from collections.abc import Callable
from typing import Any, ParamSpec, Protocol, cast

from plinko.engine.jit.decorator import EntryKernel

P = ParamSpec("P")


class Call(Protocol):
    """A call of a kernel that is repeated on the same arrays."""

    def __call__(self) -> None:
        """Run the kernel. After an exception the call must not be repeated."""

    def view(self, array: Any) -> Any:
        """The kernel's copy of one of the arrays, to be read and written between calls."""


class _PlainCall:
    """A `Call` of a function that works on the caller's arrays."""

    def __init__(self, function: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self._function = function
        self._args = args

    def __call__(self) -> None:
        self._function(*self._args)

    def view(self, array: Any) -> Any:
        return array


def in_place(function: Callable[P, None], *args: P.args, **given: P.kwargs) -> Call:
    """A repeatable call of a kernel with these arguments, whose arrays are copied only here.

    The kernel must not allocate arrays.
    """
    code = function.machine_code if isinstance(function, EntryKernel) else function
    repeated = getattr(code, "in_place", None)  # of wasmtime's code
    return _PlainCall(code, args) if repeated is None else cast("Call", repeated(args))
