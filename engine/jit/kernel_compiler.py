"""Compiles kernels with numba: for the artifacts, and in a process whose artifacts are stale.

In this package only this module, llvm_module.py and webassembly.py import numba.
"""

from functools import cache
from typing import Any

from numba import njit, types
from numba.extending import typeof_impl

from plinko.engine.jit.decorator import EntryKernel, Kernel

_types: Any = types  # numba's annotations lack the names used below
_njit: Any = njit

RULES: dict[str, Any] = {"nogil": True, "fastmath": False, "error_model": "numpy"}
"""Options for every kernel. Without the last two, results would differ between machines."""


@cache
def compiled(kernel: Kernel[Any, Any]) -> Any:
    """The kernel as numba's function, which compiles when it is first called.

    Without numba's cache on disk: it does not notice changes in the files of inlined functions.
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
    """Let a kernel call another one: numba sees the compiled function."""
    return _types.Dispatcher(compiled(kernel))
