"""Calls of kernels that are repeated on the same arrays, where these are copied once."""

from collections.abc import Callable
from importlib import import_module
from typing import Any, ParamSpec, Protocol, cast

from engine.jit.decorator import EntryKernel

P = ParamSpec("P")


class Call(Protocol):
    """A call of a kernel that is repeated on the same arrays."""

    def __call__(self) -> None:
        """Run it; not again once it has raised."""

    def view(self, array: Any) -> Any:
        """Where the kernel works on one of the arrays: what is written there is what it reads."""


class _PlainCall:
    """A `Call` of what works on Python's own arrays."""

    def __init__(self, function: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self._function = function
        self._args = args

    def __call__(self) -> None:
        """Run it."""
        self._function(*self._args)

    def view(self, array: Any) -> Any:
        """The array itself."""
        return array


def in_place(function: Callable[P, None], *args: P.args, **given: P.kwargs) -> Call:
    """A call of a kernel with these arguments, to be repeated, whose arrays are copied only now.

    For kernels that make no arrays of their own.
    """
    code: Callable[..., Any] = function
    if isinstance(function, EntryKernel):
        code = function.machine_code
        machine_code = import_module("engine.jit.machine_code")
        if isinstance(code, machine_code.Entry):
            return cast("Call", code.in_place(args))
    return _PlainCall(code, args)
