"""Compiles artifacts: records which kernels Python calls, and with which types."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types

from plinko.engine.artifact.sample_calls import SAMPLE_CALLS
from plinko.engine.jit import source_hash
from plinko.engine.jit.calls import Signature
from plinko.engine.jit.decorator import EntryKernel
from plinko.engine.jit.webassembly import Entry, compile_module

_types: Any = types  # numba's annotations lack the names used below
_numba: Any = numba


class Part(NamedTuple):
    """A kernel that was called, with numba's types of its arguments and its result."""

    kernel: EntryKernel[Any, Any]
    takes: tuple[Any, ...]
    gives: Any

    @property
    def signature(self) -> Signature:
        """These types in the form that an artifact records."""
        return Signature(_kinds(*self.takes), [] if self.gives is None else _kinds(self.gives))


def compiled(name: str) -> bytes:
    """The artifact of SAMPLE_CALLS of this name, without kernels that an earlier artifact has."""
    earlier: set[str] = set()
    for each in takewhile(lambda each: each != name, SAMPLE_CALLS):
        earlier |= recorded(SAMPLE_CALLS[each]).keys()
    parts = recorded(SAMPLE_CALLS[name])
    own = {kernel: part for kernel, part in parts.items() if kernel not in earlier}
    return module_of(own, source_hash.current())


def compiled_beside(file: Path, calls: Callable[[], None]) -> bytes:
    """The artifact of the kernels defined in `file`, which `calls` calls."""
    parts = recorded(calls)
    own = {k: p for k, p in parts.items() if Path(p.kernel.function.__code__.co_filename) == file}
    return module_of(own, source_hash.current_beside(file))


def module_of(parts: dict[str, Part], made_from: dict[str, Any]) -> bytes:
    """A stamped module with these kernels."""
    exports = {k: Entry(p.kernel.function, p.takes) for k, p in parts.items()}
    code = compile_module(exports)
    return source_hash.stamped(
        code, made_from, calls={k: p.signature._asdict() for k, p in parts.items()}
    )


def recorded(calls: Callable[[], None]) -> dict[str, Part]:
    """Run `calls` and record each kernel that Python calls, by its name.

    Raises TypeError if a kernel is called with two sets of types.
    """
    parts: dict[str, Part] = {}
    with _called_by(lambda kernel, *args: _noted(kernel, args, parts)):
        calls()
    return parts


@contextmanager
def _called_by(call: Callable[..., Any]) -> Iterator[None]:
    """Replace every kernel call by call(kernel, *args) within the context."""
    # Replacing __call__ would miss calls in place, which use `machine_code` directly.
    usual: Any = EntryKernel.__dict__["machine_code"]
    EntryKernel.machine_code = property(lambda kernel: partial(call, kernel))  # type: ignore[assignment]
    try:
        with np.errstate(all="ignore"):  # as machine code does
            yield
    finally:
        EntryKernel.machine_code = usual  # type: ignore[method-assign]


def _noted(kernel: EntryKernel[Any, Any], args: tuple[Any, ...], parts: dict[str, Part]) -> Any:
    """Run the kernel as Python and record in `parts` how it was called; returns its result."""
    takes = tuple(map(_type_of, args))
    found = kernel.function(*args)
    part = Part(kernel, takes, None if found is None else _type_of(found))
    if parts.setdefault(kernel.name, part) != part:
        raise TypeError(f"{kernel} is called with {takes} and with {parts[kernel.name].takes}")
    return found


def _type_of(value: Any) -> Any:
    """Numba's type of a value: arrays count as contiguous, numbers as eight bytes long."""
    if isinstance(value, bool | np.bool_):
        return _types.boolean
    if isinstance(value, int | np.integer):
        return _types.int64
    if isinstance(value, float | np.floating):
        return _types.float64
    if isinstance(value, np.ndarray):
        return _types.Array(_numba.from_dtype(value.dtype), value.ndim, "C")
    named = type(value) if hasattr(value, "_fields") else None
    return _types.BaseTuple.from_types(tuple(map(_type_of, value)), named)


def _kinds(*kinds: Any) -> list[str]:
    """The texts of numba's types; see calls.py."""
    texts: list[str] = []
    for kind in kinds:
        if isinstance(kind, _types.BaseTuple):
            texts += _kinds(*kind)
        elif isinstance(kind, _types.Array):
            texts.append(f"{np.dtype(str(kind.dtype)).str[1:]}:{kind.ndim}")
        else:
            texts.append({_types.boolean: "b1", _types.int64: "i8", _types.float64: "f8"}[kind])
    return texts
