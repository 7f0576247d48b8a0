"""How kernels are given to numba: what they may not do, and what need not be made of them."""

import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from numba import njit, types

from engine.jit.compiler import InnerCompiler, KernelCompiler

_njit: Any = njit  # its types leave out an option that is used below
_plain: Any = types.unliteral  # and this has none

_RULES: dict[str, Any] = {
    "nogil": True, "fastmath": False, "error_model": "numpy", "no_cfunc_wrapper": True,
    "no_rewrites": True,
}  # fmt: skip


def _stamp() -> str:
    """Hash of all sources of machine code: the packages with kernels, and the constants."""
    engine = Path(__file__).parent.parent
    sources = [engine / "constants.py"]
    for package in ("jit", "physics", "exact", "stepped", "multibody"):
        sources += (engine / package).rglob("*.py")
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in sorted(sources))).hexdigest()


_STAMP = _stamp()


def outer(function: Callable[..., Any]) -> Any:
    """`jit.kernel`.

    Numba takes cached code for fresh if the function's own file is unchanged, yet a kernel contains
    the code of those it calls, from other files. Here a change to any of the files makes all stale:
    else a new version could go on with parts of the old one's physics.
    """
    compiled = _without_literals(
        _njit(function, cache=True, pipeline_class=KernelCompiler, **_RULES)
    )
    if compiled is not function:  # else a configuration file of numba's turns the JIT off
        compiled._cache._cache_file._source_stamp = _STAMP
    return compiled


def inner(function: Callable[..., Any], *, forceinline: bool) -> Any:
    """`jit.inner_kernel`, or with forceinline `jit.lean_kernel`."""
    rules = _RULES | {"_nrt": False, "no_cpython_wrapper": True, "forceinline": forceinline}
    compiled = _without_literals(_njit(function, pipeline_class=InnerCompiler, **rules))
    if compiled is not function:
        # Numba would call the wrapper that is not there. It is told of none, asks for one to be
        # compiled, and gets the function itself.
        compiled._insert = lambda *_, **__: None
        compiled._compile_for_args = lambda *_, **__: function
    return compiled


def _without_literals(compiled: Any) -> Any:
    if hasattr(compiled, "get_call_template"):
        compiled.get_call_template = partial(_call_template, compiled.get_call_template)
    return compiled


def _call_template(original: Any, args: Any, kws: Any) -> Any:
    """What a call compiles: one function for all integers, instead of one for each constant too.

    Numba takes `kind=2` for a type of its own, and a variable for one until it has seen what else
    is assigned to it: a fifth of the time to compile would go into functions that nobody calls.
    """
    named = {name: _plain(kind) for name, kind in dict(kws).items()}
    return original(tuple(_plain(kind) for kind in args), named)
