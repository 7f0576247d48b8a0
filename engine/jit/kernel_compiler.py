"""Which way kernels are compiled: fast where numba's insides are known, else by public names alone.

Both ways give the same bits. Plain numba takes three times as long to compile: for a first drop on
triangle-16 26.4 s of processor time (once), the fast way 6.8 to 9.0 s (five times). Its code runs
about as fast, a twentieth slower at the median: `drop_many` of 20,000 on triangle-16 by one thread
gave 50,600 to 59,100 drops a second, the fast way's 56,200 to 61,700 (eight times each, in turns,
by processor time on a busy machine).
"""

import hashlib
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from numba import config, njit

_njit: Any = njit  # its types leave out options that are used below
_config: Any = config

PLAIN_SWITCH = "PLINKO_PLAIN_NUMBA"
"""Environment variable: with 1 in it kernels are compiled the plain way, without a warning."""

RULES: dict[str, Any] = {"nogil": True, "fastmath": False, "error_model": "numpy"}
"""What every kernel is compiled under, whichever way; its bits rest on the last two."""


class Way(NamedTuple):
    """How kernels are compiled."""

    name: str
    """"fast" or "plain"."""
    outer: Callable[[Callable[..., Any], str], Any]
    """Of a function and `source_stamp`: `decorator.kernel`."""
    inner: Callable[[Callable[..., Any], bool], Any]
    """Of a function and whether callers must contain it: `inner_kernel` or `lean_kernel`."""


def source_stamp() -> str:
    """SHA-256, in hexadecimal digits, of all sources of machine code: constants and kernels.

    Numba takes cached code for fresh if the function's own file is unchanged, yet a kernel contains
    the code of those it calls, from other files. With this stamp a change to any of the files makes
    all stale: else a new version could go on with parts of the old one's physics.
    """
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in sources())).hexdigest()


def sources() -> list[Path]:
    """All files of Python that machine code is made of."""
    engine = Path(__file__).parent.parent
    found = [engine / "constants.py", engine / "certified" / "reach.py"]
    for package in ("jit", "physics", "exact", "stepped", "multibody", "billiards"):
        found += (engine / package).rglob("*.py")
    return sorted(found)


def choose() -> Way:
    """The fast way; with a warning the plain one, if this numba is not known to take the fast one.

    With `PLAIN_SWITCH` set to 1, the plain way without a warning.
    """
    if os.environ.get(PLAIN_SWITCH) == "1":
        return PLAIN
    try:
        fast = import_module("engine.jit.fast_compile")
        fast.check()
    except Exception as error:  # noqa: BLE001 - whatever is amiss in there, the plain way works
        warnings.warn(
            f"kernels compile slowly, with the same results: {type(error).__name__}: {error} "
            f"({PLAIN_SWITCH}=1 chooses this without a warning)",
            RuntimeWarning,
            stacklevel=2,
        )
        return PLAIN
    return Way("fast", fast.outer, fast.inner)


def _plain_outer(function: Callable[..., Any], stamp: str) -> Any:
    """Compiled by numba's public names, its code kept in a folder with the stamp in its name.

    The folder is where numba would keep the code. One of other sources is never read again; it may
    be deleted. If numba is set to keep code elsewhere, where no stamp can be, none is kept.
    """
    usual = _njit(function, cache=True, **RULES)
    if usual is function:  # a configuration file of numba's turns the JIT off
        return function
    folder = Path(usual.stats.cache_path, f"plain-{stamp[:16]}")
    with _kept_in(folder):
        stamped = _njit(function, cache=True, **RULES)
    if Path(stamped.stats.cache_path).is_relative_to(folder):
        return stamped
    return _njit(function, **RULES)


@contextmanager
def _kept_in(folder: Path) -> Iterator[None]:
    """What is decorated meanwhile keeps its code in `folder`: NUMBA_CACHE_DIR for these alone."""
    before = _config.CACHE_DIR
    _config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        _config.CACHE_DIR = before


def _plain_inner(function: Callable[..., Any], forceinline: bool) -> Any:
    """Compiled by numba's public names; not kept, as callers contain its code."""
    return _njit(function, forceinline=forceinline, **RULES)


PLAIN = Way("plain", _plain_outer, _plain_inner)
