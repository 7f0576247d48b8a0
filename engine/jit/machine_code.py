"""Runs kernels' machine code: WebAssembly of engine/artifact, compiled and run by wasmtime.

The code knows numbers and memory. So arrays are copied into the memory of a machine and back out
again, and what it is called with is a block of eight bytes for each number that numba's code takes:
of an array two addresses that are not used here, its counts of values and of bytes in each, its own
address, shape and strides. A machine is of one thread at a time: there are as many as are needed.
The arrays of a call that is repeated (`InPlace`) stay in the memory, and nothing is copied.
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

from engine.errors import EffortError
from engine.jit import code_cache, limits, native, stamp
from engine.jit.calls import BLOCK, HEAP, STATUS, Call, Kind, Kinds, block_format, flat, leaves
from engine.jit.decorator import EntryKernel

ENGINE: Final = Path(__file__).parents[1]
FOLDER: Final = ENGINE / "artifact"

PAGE: Final = 65_536
"""Bytes that a module's memory grows by."""

_ADDRESS: Final = struct.Struct("<I")
_STATUS: Final = struct.Struct("<i")
_FINE: Final = (0, -2)  # of numba's codes: a result, or none


_alone: Final = Lock()
"""Of the thread that reads or compiles modules: others wait for what it gets."""

_modules: Final[list["Module"]] = []
"""All that were read."""


def entry(kernel: EntryKernel[Any, Any]) -> Callable[..., Any] | None:
    """The machine code of a kernel; None if no artifact has it.

    Those of the engine are in engine/artifact; another's lies beside the file of its kernels.
    """
    file = Path(kernel.function.__code__.co_filename)
    with _alone:
        found = modules() if ENGINE in file.parents else modules_beside(file)
    module = found.get(kernel.name)
    return None if module is None else Entry(module, kernel)


@cache
def modules() -> dict[str, "Module"]:
    """Name of each kernel that an artifact has: the module that it is in.

    An artifact of other sources than those that are there is none.
    """
    found = {}
    for path in sorted(FOLDER.glob("*.wasm")):
        found.update(_read(path, stamp.current()))
    return found


@cache
def modules_beside(file: Path) -> dict[str, "Module"]:
    """`modules` of the artifact beside a file of Python: of one name, made of it alone."""
    path = file.with_suffix(".wasm")
    return _read(path, stamp.current_beside(file)) if path.exists() else {}


def _read(path: Path, made_from: dict[str, Any]) -> dict[str, "Module"]:
    code = path.read_bytes()
    said = stamp.read(code)
    if not stamp.is_of(made_from, said):
        return {}
    module = Module(code, said["calls"])
    _modules.append(module)
    return dict.fromkeys(module.calls, module)


class _Compiler(NamedTuple):
    """What compiles modules, and whether their code counts its instructions."""

    engine: wasmtime.Engine
    counts: bool


@cache
def _compiler() -> _Compiler:
    counts = limits.are_limited()
    config = wasmtime.Config()
    config.parallel_compilation = False  # by threads, which a process that is forked does not have
    config.consume_fuel = counts
    return _Compiler(wasmtime.Engine(config), counts)


@atexit.register
def _let_go() -> None:
    """When Python ends: its objects are let go of by functions that are gone soon."""
    for module in _modules:
        module.close()
    _compiler.cache_clear()


def _compiled(code: bytes) -> wasmtime.Module:
    """A module for wasmtime; a process that computes for others keeps none on disk."""
    engine = _compiler().engine
    return (
        wasmtime.Module(engine, code) if native.is_forbidden() else code_cache.module(engine, code)
    )


class Module:
    """A file of machine code, and the machines that run it. Compiled when it is first needed."""

    def __init__(self, code: bytes, calls: dict[str, Any]) -> None:
        self.calls = {name: Call.read(call) for name, call in calls.items()}
        sizes = (_block(call.takes).size + _room(call.gives) for call in self.calls.values())
        self.begin = BLOCK + max(sizes)  # of what is copied, behind any call's block and results
        self._code = code
        self._compiled: wasmtime.Module | None = None
        self._idle: list[Machine] = []
        self._repeated: WeakSet[InPlace] = WeakSet()

    def take(self) -> "Machine":
        """A machine that nobody uses; for `give`, afterwards."""
        try:
            return self._idle.pop()
        except IndexError:
            return self._new_machine()

    def give(self, machine: "Machine") -> None:
        """Let others have it."""
        self._idle.append(machine)

    def in_place(self, entry: "Entry", args: Sequence[Any]) -> "InPlace":
        """A call to be repeated, with a machine of its own."""
        call = InPlace(self._new_machine(), entry, args)
        self._repeated.add(call)
        return call

    def close(self) -> None:
        """Let go of what is wasmtime's."""
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
    """A kernel of a module, to be called as the function is that it was made of."""

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
        """Run it; TypeError for arrays of other types than its own."""
        machine = self._module.take()
        found = machine.run(self, args)
        self._module.give(machine)  # one that a trap ended is not used again
        return None if self._form is None else self._form(iter(found))

    def in_place(self, args: Sequence[Any]) -> "InPlace":
        """A call with these arguments, to be repeated."""
        return self._module.in_place(self, args)


def _form(kinds: Kinds, hint: Any) -> Callable[[Iterator[Any]], Any]:
    """What makes a result of its values, its tuples named as the function says."""
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
    """All kinds in a tuple, with numpy's types of arrays."""
    return [(k, None if k.dimensions is None else np.dtype(k.name)) for k in leaves(kinds)]


def _block(takes: tuple[Kinds, ...]) -> struct.Struct:
    return struct.Struct(block_format(takes))


def _room(gives: "Kinds | None") -> int:
    """Bytes of a result; for nothing numba leaves an address of nothing."""
    return 8 if gives is None else sum(map(_size_given, leaves(gives)))


# An array that is returned, in bytes: two addresses, two counts, its own address, shape, strides.
_OWN_ADDRESS = 24
_SHAPE = 32


def _size_given(kind: Kind) -> int:
    """Bytes of a kind in a result."""
    return 8 if kind.dimensions is None else _SHAPE + 16 * kind.dimensions


class _Copy(NamedTuple):
    """An array without gaps, from where to where it is in a machine's memory, and which it is."""

    array: Any
    begin: int
    end: int
    given: Any


class _Placed(NamedTuple):
    """Values as numbers of a block, the arrays among them, and where these end."""

    numbers: list[Any]
    copies: list[_Copy]
    end: int


class Machine:
    """Memory, and the code that works on it."""

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
        self._board: Any = None  # a first argument whose arrays are in the memory, to stay
        self._kept = _Placed([], [], begin)

    def run(self, entry: Entry, args: Sequence[Any]) -> list[Any]:
        """The kernel's results, one by one; arrays that it may write to are as it left them."""
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
        """Put a call's block and its arrays into the memory, which is returned."""
        memory = self._all_memory(placed.end)
        for copy in placed.copies:
            memory[copy.begin : copy.end] = copy.array.data.cast("B")
        entry.block.pack_into(memory, BLOCK, *placed.numbers)
        _ADDRESS.pack_into(memory, HEAP, placed.end)
        return memory

    def call(self, name: str) -> memoryview:
        """Run the function of this name on what is in the memory, which is returned.

        Raises EffortError where it takes longer than it may.
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
        memory = self._all_memory(0)  # it may have grown
        (status,) = _STATUS.unpack_from(memory, STATUS)
        if status not in _FINE:
            raise RuntimeError(f"{name} ended with numba's code {status}")
        return memory

    def _placed_first(self, entry: Entry, value: Any) -> _Placed:
        """The first argument; a tuple of locked arrays, as a board is, stays for the next call."""
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
        """All of the memory, which has at least so many bytes then; it moves when it grows."""
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
    """A call that is repeated: its arguments are in the memory of a machine of its own, to stay.

    For kernels that return nothing and make no arrays, in one thread at a time.
    """

    def __init__(self, machine: Machine, entry: Entry, args: Sequence[Any]) -> None:
        placed = _placed(entry.name, entry.first + entry.rest, flat(args), machine.begin)
        self._machine: Machine | None = machine
        self._name = entry.name
        self._memory = machine.write(entry, placed)
        self._places = {id(copy.given): copy for copy in placed.copies}

    def view(self, array: Any) -> Any:
        """The place in the memory of one of the arrays that the call was made with.

        Not to be kept for longer than the call.
        """
        begin = self._places[id(array)].begin
        return np.ndarray(array.shape, array.dtype, self._memory, begin)

    def __call__(self) -> None:
        """Run the kernel; not again once it has raised."""
        assert self._machine is not None
        machine, self._machine = self._machine, None
        if machine.call(self._name) is not self._memory:
            raise RuntimeError(f"{self._name} has made arrays, and its memory has moved")
        self._machine = machine

    def close(self) -> None:
        """Let go of the machine."""
        self._machine = None


def _placed(
    name: str, kinds: Sequence[tuple[Kind, Any]], values: Iterator[Any], at: int
) -> _Placed:
    """Some of a kernel's arguments, their arrays from that address on."""
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
    """What a kernel left at an address."""
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
