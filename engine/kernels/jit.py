"""The one decorator of every kernel, so that all of them are compiled under the same rules."""

import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

from numba import njit, types

from engine.kernels.compiler import InnerCompiler, KernelCompiler

P = ParamSpec("P")
T = TypeVar("T")


def _stamp() -> str:
    """Hash of all sources that machine code is made of: kernels, solvers and the constants."""
    engine = Path(__file__).parent.parent
    sources = [*engine.glob("kernels/*.py"), *engine.glob("solvers/*.py"), engine / "constants.py"]
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in sorted(sources))).hexdigest()


_STAMP = _stamp()

_njit: Any = njit  # its types leave out an option that is used below
_plain: Any = types.unliteral  # and this has none

_RULES: dict[str, Any] = {
    "nogil": True, "fastmath": False, "error_model": "numpy", "no_cfunc_wrapper": True,
    "no_rewrites": True,
}  # fmt: skip


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile `function` so that its bits do not depend on where it runs.

    No fastmath (it reorders sums and contracts a*b+c, which differs between processors), the GIL
    released (batches use threads), machine code cached on disk beside the source, IEEE division,
    no wrapper for callers in C, as there are none, and no search for expressions of whole arrays to
    rewrite. With NUMBA_DISABLE_JIT=1 the function itself is returned: the same bits, slower.

    Numba takes cached code for fresh if the function's own file is unchanged, yet a kernel contains
    the code of those it calls, from other files. Here a change to any of the files makes all stale:
    else a new version could go on with parts of the old one's physics.
    """
    compiled = _without_literals(
        _njit(function, cache=True, pipeline_class=KernelCompiler, **_RULES)
    )
    if compiled is not function:  # else the JIT is off
        compiled._cache._cache_file._source_stamp = _STAMP
    return cast("Callable[P, T]", compiled)


def inner_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`kernel` for a function inside of others that makes no arrays, nor calls one that does.

    Its arrays' references are not counted: numba otherwise counts them at each call, by atomic
    operations that cost more than the call. To make an array in one is an error when it is
    compiled. Nor is there machine code of its own (callers contain theirs), and so nothing to keep
    on disk and no wrapper for callers in Python: there it runs as Python runs it, with the same
    bits. That is a fifth of all compile time.
    """
    return _inner(function, forceinline=False)


def lean_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`inner_kernel` that leaves the compiler no choice but to put it into its callers.

    For innermost loops: there flights take a fifth less time. In large functions with many callers
    it only costs compile time.
    """
    return _inner(function, forceinline=True)


def _inner(function: Callable[P, T], *, forceinline: bool) -> Callable[P, T]:
    rules = _RULES | {"_nrt": False, "no_cpython_wrapper": True, "forceinline": forceinline}
    compiled = _without_literals(_njit(function, pipeline_class=InnerCompiler, **rules))
    if compiled is not function:
        # Numba would call the wrapper that is not there. It is told of none, asks for one to be
        # compiled, and gets the function itself.
        compiled._insert = lambda *_, **__: None
        compiled._compile_for_args = lambda *_, **__: function
    return cast("Callable[P, T]", compiled)


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
