"""Kernels as numba compiles them: for artifacts, and where it changed since those were made.

Only here and in webassembly.py is numba asked for anything.
"""

from functools import cache
from typing import Any

from numba import njit, types
from numba.extending import typeof_impl

from engine.jit.decorator import EntryKernel, Kernel

_types: Any = types  # its types leave out what is used below
_njit: Any = njit

RULES: dict[str, Any] = {"nogil": True, "fastmath": False, "error_model": "numpy"}
"""What every kernel is compiled under; its bits rest on the last two."""


@cache
def compiled(kernel: Kernel[Any, Any]) -> Any:
    """The kernel as numba's function, which compiles when it is called.

    Nothing is kept on disk: numba takes such code for fresh though it contains that of functions in
    files which have changed.
    """
    is_entry = isinstance(kernel, EntryKernel)
    return _njit(
        kernel.function,
        forceinline=kernel.forceinline,
        no_cpython_wrapper=not is_entry,
        no_cfunc_wrapper=True,
        **RULES,
    )


@typeof_impl.register(Kernel)
def _type_of_kernel(kernel: Kernel[Any, Any], _: Any) -> Any:
    """A kernel that another one names is numba's function of it."""
    return _types.Dispatcher(compiled(kernel))
