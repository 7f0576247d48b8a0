"""The one decorator of every kernel, so that all of them are compiled under the same rules."""

import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

from numba import njit, types

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
    "cache": True, "nogil": True, "fastmath": False, "error_model": "numpy",
    "no_cfunc_wrapper": True,
}  # fmt: skip


def kernel(function: Callable[P, T]) -> Callable[P, T]:
    """Compile `function` so that its bits do not depend on where it runs.

    No fastmath (it reorders sums and contracts a*b+c, which differs between processors), the GIL
    released (batches use threads), machine code cached on disk beside the source, IEEE division,
    and no wrapper for callers in C, as there are none. With NUMBA_DISABLE_JIT=1 the function itself
    is returned: the same bits, slower.

    Numba takes cached code for fresh if the function's own file is unchanged, yet a kernel contains
    the code of those it calls, from other files. Here a change to any of the files makes all stale:
    else a new version could go on with parts of the old one's physics.
    """
    return _stamped(function, _njit(**_RULES))


def lean_kernel(function: Callable[P, T]) -> Callable[P, T]:
    """`kernel` for a function that makes no arrays, nor calls one that does: its own are not
    counted. Numba otherwise counts references at each call, by atomic operations that cost more
    than the call. To make an array in one is an error when it is compiled."""
    return _stamped(function, _njit(**_RULES, _nrt=False, forceinline=True))


def _stamped(function: Callable[P, T], compiler: Any) -> Callable[P, T]:
    compiled = compiler(function)
    if compiled is not function:  # else the JIT is off
        compiled._cache._cache_file._source_stamp = _STAMP
        compiled.get_call_template = partial(_call_template, compiled.get_call_template)
    return cast("Callable[P, T]", compiled)


def _call_template(original: Any, args: Any, kws: Any) -> Any:
    """What a call compiles: one function for all integers, instead of one for each constant too.

    Numba takes `kind=2` for a type of its own, and a variable for one until it has seen what else
    is assigned to it: a fifth of the time to compile would go into functions that nobody calls.
    """
    named = {name: _plain(kind) for name, kind in dict(kws).items()}
    return original(tuple(_plain(kind) for kind in args), named)
