"""Loads native code of kernels from engine/artifact/native, if this machine can run it.

Native code takes half the time of WebAssembly, but has neither its sandbox nor its count of
instructions. So it runs only batches that a person has asked for, and never in a process that
serves others. It works on arrays in place. engine/exact/lanes/trial.py tests whether its results
are right on this machine.
"""

import ctypes
import json
import os
import platform
import struct
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from threading import Event
from typing import Any, Final

from plinko.engine.jit import limits, source_hash
from plinko.engine.jit.calls import FINE, Signature, block_format, dimensions, flat
from plinko.engine.jit.decorator import IS_OFF
from plinko.engine.jit.decorator import SWITCH as JIT_SWITCH

FOLDER: Final = Path(__file__).parents[1] / "artifact" / "native"
INDEX: Final = FOLDER / "index.json"

SWITCH: Final = "PLINKO_NATIVE"
"""An environment variable; 0 turns native code off."""

_V3 = {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"}
_V4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}

_forbidden: Final = Event()


class NoNativeCodeError(Exception):
    """Native code does not run in this process; the message says why."""


def forbid() -> None:
    """Run no native code from now on. For processes that compute for others."""
    _forbidden.set()


def is_forbidden() -> bool:
    """Whether this process must not run native code, because it computes for others."""
    return _forbidden.is_set() or limits.are_limited()


def _library() -> str:
    """The name of the library for this machine. Raises NoNativeCodeError."""
    if os.environ.get(SWITCH) == "0" or IS_OFF:
        raise NoNativeCodeError(f"{SWITCH if not IS_OFF else JIT_SWITCH} turns native code off")
    machine = platform.machine()
    if sys.platform == "linux" and machine == "aarch64":
        return machine
    flags = _flags() if sys.platform == "linux" and machine == "x86_64" else set()
    if not flags >= _V3:
        raise NoNativeCodeError(
            f"there is no native code for this processor, {machine} of {sys.platform}"
        )
    return "x86-64-v4" if flags >= _V4 else "x86-64-v3"


def _flags() -> set[str]:
    """The processor's features, from /proc/cpuinfo."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return set()
    for line in text.splitlines():
        name, _, value = line.partition(":")
        if name.strip() == "flags":
            return set(value.split())
    return set()


class NativeKernel:
    """A native kernel that returns nothing; takes the arguments of its Python function."""

    def __init__(self, name: str, function: Any, signature: Signature) -> None:
        self.name = name
        self._function = function
        self._takes = signature.takes
        self._block = struct.Struct(block_format(signature.takes))

    def __call__(self, *args: Any) -> None:
        """Run the kernel. Raises TypeError if an array has another type or is not contiguous."""
        numbers: list[Any] = []
        for kind, value in zip(self._takes, flat(args), strict=True):
            numbers += [value] if not dimensions(kind) else _array(self.name, kind, value)
        status = self._function(self._block.pack(*numbers))
        if status not in FINE:
            raise RuntimeError(f"{self.name} ended with numba's code {status}")


def _array(name: str, kind: str, value: Any) -> list[int]:
    """The numbers that numba's code takes for an array."""
    fits = f"{value.dtype.str[1:]}:{value.ndim}" == kind
    if not fits or not value.flags.c_contiguous:
        raise TypeError(f"{name} takes an array {kind} without gaps, not {value.dtype}")
    address: int = value.ctypes.data
    return [0, 0, value.size, value.itemsize, address, *value.shape, *value.strides]


def load() -> dict[str, Callable[..., None]]:
    """The kernels of this machine's library by name. Raises NoNativeCodeError."""
    name = _library()
    path = FOLDER / f"{name}.so"
    try:
        said = json.loads(INDEX.read_bytes())
        if not source_hash.is_of(source_hash.current(), said):
            raise NoNativeCodeError("native code is out of date; run `make kernels`")
        if sha256(path.read_bytes()).hexdigest() != said["libraries"][name]:
            raise NoNativeCodeError(
                f"{path.name} has changed since it was made; run `make kernels`"
            )
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise NoNativeCodeError(f"{path.name} cannot be loaded: {error}") from None
    found: dict[str, Callable[..., None]] = {}
    for kernel, call in said["calls"].items():
        function = library[kernel]
        function.argtypes = [ctypes.c_char_p]
        function.restype = ctypes.c_int32
        found[kernel] = NativeKernel(kernel, function, Signature(**call))
    return found
