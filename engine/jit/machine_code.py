"""Runs the kernels' machine code: the WebAssembly of engine/artifact, compiled by wasmtime.

WebAssembly code sees only numbers and its own memory. So arrays are copied into the memory of a
`Machine` before a call and back after it. The arguments are a block with eight bytes for each
number that numba's code takes. For an array these are two addresses (unused here), the number of
values, the bytes of each, the array's address, its shape and its strides. Only one thread may use a
machine at a time; more are created as needed. The arrays of a repeated call (`InPlace`) stay in
the memory, so nothing is copied.
"""

import atexit
import ctypes
import struct
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any, Final, NamedTuple, get_args, get_type_hints
from weakref import WeakSet

import numpy as np
import wasmtime

from plinko.engine.errors import EffortError
from plinko.engine.jit import code_cache, limits, native, source_hash
from plinko.engine.jit.calls import (
    BLOCK,
    HEAP,
    STATUS,
    Call,
    Kind,
    Kinds,
    block_format,
    flat,
    leaves,
)
from plinko.engine.jit.decorator import EntryKernel

ENGINE: Final = Path(__file__).parents[1]
FOLDER: Final = ENGINE / "artifact"

PAGE: Final = 65_536
"""Bytes of a page, the unit in which a module's memory grows."""

_ADDRESS: Final = struct.Struct("<I")
_STATUS: Final = struct.Struct("<i")
_FINE: Final = (0, -2)  # numba's codes for success, with and without a result


_alone: Final = Lock()
"""Lets only one thread read or compile modules; the others wait and then find the result."""

_modules: Final[list["Module"]] = []
"""All modules read, for `_let_go`."""


def entry(kernel: EntryKernel[Any, Any]) -> Callable[..., Any] | None:
    """The machine code of a kernel; None if no artifact that is up to date has it.

    The engine's artifacts are in engine/artifact; any other is next to the file of its kernels.
    """
    file = Path(kernel.function.__code__.co_filename)
    with _alone:
        found = modules() if ENGINE in file.parents else modules_beside(file)
    module = found.get(kernel.name)
    return None if module is None else Entry(module, kernel)


@cache
def modules() -> dict[str, "Module"]:
    """The module of each kernel, by the kernel's name. Stale artifacts are ignored.

    A kernel that several artifacts have is run by the first, so that a single drop loads only one.
    """
    found: dict[str, Module] = {}
    for path in sorted(FOLDER.glob("*.wasm")):
        found = _read(path, source_hash.current()) | found
    return found


@cache
def modules_beside(file: Path) -> dict[str, "Module"]:
    """`modules` of the artifact next to a Python file, which has the same name."""
    path = file.with_suffix(".wasm")
    return _read(path, source_hash.current_beside(file)) if path.exists() else {}


def _read(path: Path, made_from: dict[str, Any]) -> dict[str, "Module"]:
    code = path.read_bytes()
    said = source_hash.read(code)
    if not source_hash.is_of(made_from, said):
        return {}
    module = Module(code, said["calls"])
    _modules.append(module)
    return dict.fromkeys(module.calls, module)


class _Compiler(NamedTuple):
    """wasmtime's engine, and whether the code that it compiles counts instructions."""

    engine: wasmtime.Engine
    counts: bool


@cache
def _compiler() -> _Compiler:
    counts = limits.are_limited()
    config = wasmtime.Config()
    config.parallel_compilation = False  # its threads would not exist in a forked process
    config.consume_fuel = counts
    return _Compiler(wasmtime.Engine(config), counts)


@atexit.register
def _let_go() -> None:
    """Release wasmtime's objects before Python exits: later, their destructors would be gone."""
    for module in _modules:
        module.close()
    _compiler.cache_clear()


def _compiled(code: bytes) -> wasmtime.Module:
    """Compile a module; a process that computes for others does not use the cache on disk."""
    engine = _compiler().engine
    return (
        wasmtime.Module(engine, code) if native.is_forbidden() else code_cache.module(engine, code)
    )


class Module:
    """A file of machine code and the machines that run it; compiled when first needed."""

    def __init__(self, code: bytes, calls: dict[str, Any]) -> None:
        self.calls = {name: Call.read(call) for name, call in calls.items()}
        sizes = (_block(call.takes).size + _room(call.gives) for call in self.calls.values())
        self.begin = BLOCK + max(sizes)  # of copied arrays, after any call's block and results
        self._code = code
        self._compiled: wasmtime.Module | None = None
        self._idle: list[Machine] = []
        self._repeated: WeakSet[InPlace] = WeakSet()

    def take(self) -> "Machine":
        """An idle machine, or a new one; the caller returns it with `give`."""
        try:
            return self._idle.pop()
        except IndexError:
            return self._new_machine()

    def give(self, machine: "Machine") -> None:
        """Return a machine for other calls."""
        self._idle.append(machine)

    def in_place(self, entry: "Entry", args: Sequence[Any]) -> "InPlace":
        call = InPlace(self._new_machine(), entry, args)
        self._repeated.add(call)
        return call

    def close(self) -> None:
        """Release wasmtime's objects."""
        self._idle.clear()
        self._compiled = None
        for call in self._repeated:
            call.close()

    def _new_machine(self) -> "Machine":
        with _alone:
            if self._compiled is None:
                self._compiled = _compiled(self._code)
        return Machine(self._compiled, self.begin)


class Entry:
    """A kernel of a module; takes the arguments of its Python function."""

    def __init__(self, module: Module, kernel: EntryKernel[Any, Any]) -> None:
        self._module = module
        self.name = kernel.name
        takes, gives = module.calls[kernel.name]
        self.first, self.rest = _dtypes(takes[:1]), _dtypes(takes[1:])
        self.block = _block(takes)
        self.gives = () if gives is None else tuple(leaves(gives))
        hint = get_type_hints(kernel.function).get("return")
        self._form = None if gives is None else _form(gives, hint)

    def __call__(self, *args: Any) -> Any:
        """Run the kernel. Raises TypeError if an array has another type."""
        machine = self._module.take()
        found = machine.run(self, args)
        self._module.give(machine)  # not after a trap, which leaves the machine in an unknown state
        return None if self._form is None else self._form(iter(found))

    def in_place(self, args: Sequence[Any]) -> "InPlace":
        return self._module.in_place(self, args)


def _form(kinds: Kinds, hint: Any) -> Callable[[Iterator[Any]], Any]:
    """A function that makes a result from its values, with the named tuples of the type hint."""
    if isinstance(kinds, Kind):
        return next
    named = hasattr(hint, "_fields")
    hints = get_type_hints(hint).values() if named else get_args(hint)
    parts = [_form(kind, each) for kind, each in zip(kinds, hints, strict=True)]

    def made(values: Iterator[Any]) -> Any:
        found = tuple(part(values) for part in parts)
        return hint(*found) if named else found

    return made


def _dtypes(kinds: tuple[Kinds, ...]) -> list[tuple[Kind, Any]]:
    """All kinds in a tuple, each with numpy's type of its array, None for a number."""
    return [(k, None if k.dimensions is None else np.dtype(k.name)) for k in leaves(kinds)]


def _block(takes: tuple[Kinds, ...]) -> struct.Struct:
    return struct.Struct(block_format(takes))


def _room(gives: "Kinds | None") -> int:
    """Bytes of a result; without one, numba still writes a null address."""
    return 8 if gives is None else sum(map(_size_given, leaves(gives)))


# Offsets in a returned array: two addresses, two counts, the array's address, shape, strides.
_OWN_ADDRESS = 24
_SHAPE = 32


def _size_given(kind: Kind) -> int:
    """Bytes of a kind in a result."""
    return 8 if kind.dimensions is None else _SHAPE + 16 * kind.dimensions


class _Copy(NamedTuple):
    """A contiguous array, its begin and end in a machine's memory, and the caller's array."""

    array: Any
    begin: int
    end: int
    given: Any


class _Placed(NamedTuple):
    """Arguments as numbers of a block, the arrays among them, and the end of these in memory."""

    numbers: list[Any]
    copies: list[_Copy]
    end: int


class Machine:
    """An instance of a module with its memory, for one thread at a time."""

    def __init__(self, module: wasmtime.Module, begin: int) -> None:
        engine, self._counts = _compiler()
        self._store = wasmtime.Store(engine)
        self._memory = wasmtime.Memory(self._store, wasmtime.MemoryType(wasmtime.Limits(5, None)))
        kind = wasmtime.GlobalType(wasmtime.ValType.i32(), True)
        stack = wasmtime.Global(self._store, kind, wasmtime.Val.i32(BLOCK))
        given: dict[str, Any] = {"__linear_memory": self._memory, "__stack_pointer": stack}
        imports = [given[str(each.name)] for each in module.imports]
        self._exports: Any = wasmtime.Instance(self._store, module, imports).exports(self._store)
        self._view = memoryview(b"")
        self.begin = begin
        self._board: Any = None  # a first argument whose arrays stay in the memory between calls
        self._kept = _Placed([], [], begin)

    def run(self, entry: Entry, args: Sequence[Any]) -> list[Any]:
        """Run the kernel; returns the values of its result. Writable arrays are copied back."""
        first = self._placed_first(entry, args[0])
        rest = _placed(entry.name, entry.rest, flat(args[1:]), first.end)
        copies = first.copies + rest.copies
        self.write(entry, _Placed(first.numbers + rest.numbers, copies, rest.end))
        memory = self.call(entry.name)
        for copy in copies:
            if copy.given.flags.writeable:
                copy.array.data.cast("B")[:] = memory[copy.begin : copy.end]
                if copy.given is not copy.array:
                    copy.given[...] = copy.array
        return _results(entry.gives, memory, BLOCK + entry.block.size)

    def write(self, entry: Entry, placed: _Placed) -> memoryview:
        """Write a call's block and its arrays; returns the memory."""
        memory = self._all_memory(placed.end)
        for copy in placed.copies:
            memory[copy.begin : copy.end] = copy.array.data.cast("B")
        entry.block.pack_into(memory, BLOCK, *placed.numbers)
        _ADDRESS.pack_into(memory, HEAP, placed.end)
        return memory

    def call(self, name: str) -> memoryview:
        """Run a function on the arguments in the memory; returns the memory.

        Raises EffortError if calls are limited and this one reaches its limit.
        """
        most = limits.most()
        if self._counts:
            self._store.set_fuel(most)
        try:
            self._exports[name](self._store)
        except wasmtime.Trap as trap:
            if trap.trap_code is not wasmtime.TrapCode.OUT_OF_FUEL:
                raise
            raise EffortError(
                f"too much to compute: {name.rpartition('.')[2]} has not ended after {most:,} "
                "instructions"
            ) from None
        memory = self._all_memory(0)  # the call may have grown it
        (status,) = _STATUS.unpack_from(memory, STATUS)
        if status not in _FINE:
            raise RuntimeError(f"{name} ended with numba's code {status}")
        return memory

    def _placed_first(self, entry: Entry, value: Any) -> _Placed:
        """The first argument. A tuple of read-only arrays, such as a board, is not copied again if
        the next call has the same one.
        """
        if value is self._board:
            return self._kept
        placed = _placed(entry.name, entry.first, flat((value,)), self.begin)
        locked = not any(copy.given.flags.writeable for copy in placed.copies)
        if locked and isinstance(value, tuple):
            self._board, self._kept = value, placed._replace(copies=[])
        else:
            self._board = None
        return placed

    def _all_memory(self, size: int) -> memoryview:
        """All of the memory, grown to at least `size` bytes; growing may move it."""
        length = self._memory.data_len(self._store)
        if size > length:
            self._memory.grow(self._store, -(-(size - length) // PAGE))
            length = self._memory.data_len(self._store)
        if length != len(self._view):
            begin: Any = self._memory.data_ptr(self._store)
            everything = (ctypes.c_ubyte * length).from_address(ctypes.addressof(begin.contents))
            self._view = memoryview(everything).cast("B")
        return self._view


class InPlace:
    """A repeatable call with a private machine, in whose memory the arguments stay.

    For kernels that return nothing and allocate no arrays; one thread at a time.
    """

    def __init__(self, machine: Machine, entry: Entry, args: Sequence[Any]) -> None:
        placed = _placed(entry.name, entry.first + entry.rest, flat(args), machine.begin)
        self._machine: Machine | None = machine
        self._name = entry.name
        self._memory = machine.write(entry, placed)
        self._places = {id(copy.given): copy for copy in placed.copies}

    def view(self, array: Any) -> Any:
        """The copy in the memory of one of the arrays that the call was made with.

        It must not outlive the call.
        """
        begin = self._places[id(array)].begin
        return np.ndarray(array.shape, array.dtype, self._memory, begin)

    def __call__(self) -> None:
        """Run the kernel. After an exception the call must not be repeated."""
        assert self._machine is not None
        machine, self._machine = self._machine, None
        if machine.call(self._name) is not self._memory:
            raise RuntimeError(f"{self._name} has made arrays, and its memory has moved")
        self._machine = machine

    def close(self) -> None:
        self._machine = None


def _placed(
    name: str, kinds: Sequence[tuple[Kind, Any]], values: Iterator[Any], at: int
) -> _Placed:
    """Place some of a kernel's arguments, with their arrays from the address `at` on."""
    numbers: list[Any] = []
    copies: list[_Copy] = []
    for (kind, dtype), value in zip(kinds, values, strict=True):
        if dtype is None:
            numbers.append(value)
            continue
        if value.dtype != dtype or value.ndim != kind.dimensions:
            raise TypeError(
                f"{name} takes no array of {value.dtype} in {value.ndim} dimensions: {kind}"
            )
        array = value if value.flags.c_contiguous else np.ascontiguousarray(value)
        numbers += (0, 0, array.size, array.itemsize, at, *array.shape, *array.strides)
        if array.size:
            copies.append(_Copy(array, at, at + array.nbytes, value))
        at += -(-array.nbytes // 8) * 8
    return _Placed(numbers, copies, at)


def _results(kinds: Sequence[Kind], memory: memoryview, at: int) -> list[Any]:
    """Read a kernel's results from the address `at`."""
    found: list[Any] = []
    for kind in kinds:
        if kind.dimensions is not None:
            found.append(_array(kind, memory, at))
        elif kind.name == "b1":
            found.append(bool(memory[at]))
        else:
            found += struct.unpack_from("<d" if kind.name == "f8" else "<q", memory, at)
        at += _size_given(kind)
    return found


def _array(kind: Kind, memory: memoryview, at: int) -> Any:
    (address,) = _ADDRESS.unpack_from(memory, at + _OWN_ADDRESS)
    array = np.empty(struct.unpack_from(f"<{kind.dimensions}q", memory, at + _SHAPE), kind.name)
    if array.size:
        array.data.cast("B")[:] = memory[address : address + array.nbytes]
    return array
