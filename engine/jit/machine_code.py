"""Runs the kernels' machine code: the WebAssembly of engine/artifact, compiled by wasmtime.

WebAssembly code sees only numbers and its own memory. So arrays are copied into the memory of a
`Machine` before a call and back after it. The arguments are a block with eight bytes for each
number that numba's code takes. For an array these are two addresses (unused here), the number of
values, the bytes of each, the array's address, its shape and its strides. Only one thread may use a
machine at a time; more are created as needed. A repeated call has a machine of its own, in whose
memory the arrays stay, so nothing is copied.
"""

import atexit
import ctypes
import struct
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from threading import Lock
from types import SimpleNamespace
from typing import Any, Final, NamedTuple, get_args, get_origin, get_type_hints
from weakref import WeakSet

import numpy as np
import wasmtime

from plinko.engine.errors import EffortError
from plinko.engine.jit import code_cache, limits, native, source_hash
from plinko.engine.jit.calls import (
    BLOCK,
    FINE,
    HEAP,
    STATUS,
    Signature,
    block_format,
    dimensions,
    flat,
)
from plinko.engine.jit.decorator import EntryKernel

ENGINE: Final = Path(__file__).parents[1]
FOLDER: Final = ENGINE / "artifact"

PAGE: Final = 65_536
"""Bytes of a page, the unit in which a module's memory grows."""

_ADDRESS: Final = struct.Struct("<I")
_STATUS: Final = struct.Struct("<i")

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
    return dict.fromkeys(module.signatures, module)


@cache
def _compiler() -> tuple[wasmtime.Engine, bool]:
    """wasmtime's engine, and whether the code that it compiles counts instructions."""
    counts = limits.are_limited()
    config = wasmtime.Config()
    config.parallel_compilation = False  # its threads would not exist in a forked process
    config.consume_fuel = counts
    return wasmtime.Engine(config), counts


@atexit.register
def _let_go() -> None:
    """Release wasmtime's objects before Python exits: later, their destructors would be gone."""
    for module in _modules:
        module.close()
    _compiler.cache_clear()


def _compiled(code: bytes) -> wasmtime.Module:
    """Compile a module; a process that computes for others does not use the cache on disk."""
    engine, _ = _compiler()
    return (
        wasmtime.Module(engine, code) if native.is_forbidden() else code_cache.module(engine, code)
    )


class Module:
    """A file of machine code and the machines that run it; compiled when first needed."""

    def __init__(self, code: bytes, calls: dict[str, Any]) -> None:
        self.signatures = {name: Signature(**call) for name, call in calls.items()}
        sizes = (_block(each).size + _room(each.gives) for each in self.signatures.values())
        self.begin = BLOCK + max(sizes)  # of copied arrays, after any call's block and results
        self._code = code
        self._compiled: wasmtime.Module | None = None
        self._idle: list[Machine] = []
        self._machines: WeakSet[Machine] = WeakSet()

    def take(self) -> "Machine":
        """An idle machine, or a new one; the caller returns it with `give`."""
        try:
            return self._idle.pop()
        except IndexError:
            return self.new_machine()

    def give(self, machine: "Machine") -> None:
        self._idle.append(machine)

    def new_machine(self) -> "Machine":
        with _alone:
            if self._compiled is None:
                self._compiled = _compiled(self._code)
        machine = Machine(self._compiled, self.begin)
        self._machines.add(machine)
        return machine

    def close(self) -> None:
        self._idle.clear()
        self._compiled = None
        for machine in self._machines:
            machine.close()


class Entry:
    """A kernel of a module; takes the arguments of its Python function."""

    def __init__(self, module: Module, kernel: EntryKernel[Any, Any]) -> None:
        self._module = module
        self.name = kernel.name
        signature = module.signatures[kernel.name]
        self.takes = [(kind, _array_type(kind)) for kind in signature.takes]
        self.block = _block(signature)
        self.gives = signature.gives
        self._form = _form(get_type_hints(kernel.function).get("return"))

    def __call__(self, *args: Any) -> Any:
        """Run the kernel. Raises TypeError if an array has another type."""
        machine = self._module.take()
        found = machine.run(self, args)
        self._module.give(machine)  # not after a trap, which leaves the machine in an unknown state
        return self._form(iter(found)) if self.gives else None

    def in_place(self, args: Sequence[Any]) -> "Machine":
        """A machine that repeats this call, for a kernel that allocates no arrays."""
        machine = self._module.new_machine()
        machine.prepare(self, args)
        return machine


def _form(hint: Any) -> Callable[[Iterator[Any]], Any]:
    """A function that makes a result of this type from its values: nested and named tuples."""
    is_named = hasattr(hint, "_fields")
    hints = get_type_hints(hint).values() if is_named else get_args(hint)
    if not is_named and get_origin(hint) is not tuple:
        return next
    parts = [_form(each) for each in hints]

    def made(values: Iterator[Any]) -> Any:
        found = tuple(part(values) for part in parts)
        return hint(*found) if is_named else found

    return made


def _array_type(kind: str) -> tuple[Any, int] | None:
    """Numpy's type of an array, and its dimensions; None for a number."""
    name, _, count = kind.partition(":")
    return (np.dtype(name), int(count)) if count else None


def _block(signature: Signature) -> struct.Struct:
    return struct.Struct(block_format(signature.takes))


# Offsets in a returned array: two addresses, two counts, the array's address, shape, strides.
_OWN_ADDRESS = 24
_SHAPE = 32


def _room(gives: Sequence[str]) -> int:
    """Bytes of the results; without any, numba still writes a null address."""
    return max(8, sum(map(_size_given, gives)))


def _size_given(kind: str) -> int:
    """Bytes of one result."""
    return _SHAPE + 16 * dimensions(kind) if dimensions(kind) else 8


class _Copy(NamedTuple):
    """A contiguous array, its begin and end in a machine's memory, and the caller's array."""

    array: Any
    begin: int
    end: int
    given: Any


def _no_values(store: wasmtime.Store) -> SimpleNamespace:
    """The type of every kernel's function; wasmtime takes 4 us to read it at each call."""
    return _NO_VALUES


_NO_VALUES: Final = SimpleNamespace(params=(), results=())


class Machine:
    """An instance of a module with its memory, for one thread at a time."""

    def __init__(self, module: wasmtime.Module, begin: int) -> None:
        engine, self._counts = _compiler()
        self._store: Any = wasmtime.Store(engine)
        self._memory: Any = wasmtime.Memory(
            self._store, wasmtime.MemoryType(wasmtime.Limits(5, None))
        )
        kind = wasmtime.GlobalType(wasmtime.ValType.i32(), True)
        stack = wasmtime.Global(self._store, kind, wasmtime.Val.i32(BLOCK))
        given: dict[str, Any] = {"__linear_memory": self._memory, "__stack_pointer": stack}
        imports = [given[str(each.name)] for each in module.imports]
        self._exports: Any = wasmtime.Instance(self._store, module, imports).exports(self._store)
        function: Any
        for function in self._exports.values():
            function.type = _no_values
        self._view = memoryview(b"")
        self._begin = begin
        self._board: Any = None  # a first argument whose arrays stay in the memory between calls
        self._numbers: list[Any] = []  # its part of the block
        self._board_end = begin
        self._name = ""  # of the call that is repeated
        self._places: dict[int, int] = {}  # where its arrays are, by their id

    def run(self, entry: Entry, args: Sequence[Any]) -> list[Any]:
        """Run the kernel; returns the values of its result. Writable arrays are copied back."""
        copies = self._place(entry, args)
        memory = self.call(entry.name)
        for copy in copies:
            if copy.given.flags.writeable:
                copy.array.data.cast("B")[:] = memory[copy.begin : copy.end]
                if copy.given is not copy.array:
                    copy.given[...] = copy.array
        return _results(entry.gives, memory, BLOCK + entry.block.size)

    def prepare(self, entry: Entry, args: Sequence[Any]) -> None:
        """Prepare a call that is repeated on these arrays."""
        copies = self._place(entry, args, keeps_board=False)
        self._name = entry.name
        self._places = {id(copy.given): copy.begin for copy in copies}

    def repeat(self) -> None:
        """Repeat the prepared call. After an exception it must not be repeated."""
        memory = self._view
        if self.call(self._name) is not memory:
            raise RuntimeError(f"{self._name} has made arrays, and its memory has moved")

    def view(self, array: Any) -> Any:
        """The copy in the memory of one of the prepared arrays; it must not outlive the machine."""
        return np.ndarray(array.shape, array.dtype, self._view, self._places[id(array)])

    def call(self, name: str) -> memoryview:
        """Run a function on the arguments in the memory; returns the memory.

        Raises EffortError if calls are limited and this one reaches its limit. After an exception
        the machine is in an unknown state, and cannot be called again.
        """
        most = limits.most()
        if self._counts:
            self._store.set_fuel(most)
        exports, self._exports = self._exports, None
        assert exports is not None
        try:
            exports[name](self._store)
        except wasmtime.Trap as trap:
            if trap.trap_code is not wasmtime.TrapCode.OUT_OF_FUEL:
                raise
            raise EffortError(
                f"too much to compute: {name.rpartition('.')[2]} has not ended after {most:,} "
                "instructions"
            ) from None
        memory = self._all_memory(0)  # the call may have grown it
        (status,) = _STATUS.unpack_from(memory, STATUS)
        if status not in FINE:
            raise RuntimeError(f"{name} ended with numba's code {status}")
        self._exports = exports
        return memory

    def close(self) -> None:
        self._exports = self._memory = self._store = None

    def _place(self, entry: Entry, args: Sequence[Any], *, keeps_board: bool = True) -> list[_Copy]:
        """Write a call's block and its arrays into the memory.

        A first argument that is a tuple of read-only arrays, such as a board, is not copied again
        if the next call has the same one.
        """
        first = list(flat(args[:1]))
        copies: list[_Copy] = []
        if args[0] is not self._board:
            kinds = entry.takes[: len(first)]
            self._numbers, copies, self._board_end = _placed(entry.name, kinds, first, self._begin)
            is_locked = not any(copy.given.flags.writeable for copy in copies)
            is_kept = keeps_board and is_locked and isinstance(args[0], tuple)
            self._board = args[0] if is_kept else None
        others, more, end = _placed(
            entry.name, entry.takes[len(first) :], list(flat(args[1:])), self._board_end
        )
        memory = self._all_memory(end)
        for copy in (*copies, *more):
            memory[copy.begin : copy.end] = copy.array.data.cast("B")
        entry.block.pack_into(memory, BLOCK, *self._numbers, *others)
        _ADDRESS.pack_into(memory, HEAP, end)
        return [*copies, *more]

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


def _placed(
    name: str, kinds: Sequence[tuple[str, Any]], values: Sequence[Any], at: int
) -> tuple[list[Any], list[_Copy], int]:
    """Place arguments of a kernel, with their arrays from the address `at` on: their numbers in the
    block, their arrays, and the end of these in memory."""
    numbers: list[Any] = []
    copies: list[_Copy] = []
    for (kind, array_type), value in zip(kinds, values, strict=True):
        if array_type is None:
            numbers.append(value)
            continue
        if (value.dtype, value.ndim) != array_type:
            raise TypeError(
                f"{name} takes an array {kind}, not {value.dtype} in {value.ndim} dimensions"
            )
        array = value if value.flags.c_contiguous else np.ascontiguousarray(value)
        numbers += (0, 0, array.size, array.itemsize, at, *array.shape, *array.strides)
        if array.size:
            copies.append(_Copy(array, at, at + array.nbytes, value))
        at += -(-array.nbytes // 8) * 8
    return numbers, copies, at


def _results(kinds: Sequence[str], memory: memoryview, at: int) -> list[Any]:
    found: list[Any] = []
    for kind in kinds:
        if dimensions(kind):
            found.append(_array(kind, memory, at))
        elif kind == "b1":
            found.append(bool(memory[at]))
        else:
            found += struct.unpack_from("<d" if kind == "f8" else "<q", memory, at)
        at += _size_given(kind)
    return found


def _array(kind: str, memory: memoryview, at: int) -> Any:
    (address,) = _ADDRESS.unpack_from(memory, at + _OWN_ADDRESS)
    name, _, count = kind.partition(":")
    array = np.empty(struct.unpack_from(f"<{count}q", memory, at + _SHAPE), name)
    if array.size:
        array.data.cast("B")[:] = memory[address : address + array.nbytes]
    return array
