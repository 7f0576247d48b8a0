"""Reads and edits WebAssembly modules: adds exports to an object file, and custom sections.

The format is described in https://webassembly.github.io/spec/core/binary/modules.html, the symbols
of object files in https://github.com/WebAssembly/tool-conventions/blob/main/Linking.md.
"""

from collections.abc import Iterator
from typing import Final

HEADER: Final = b"\0asm\1\0\0\0"

CUSTOM: Final = 0
EXPORT: Final = 7
START: Final = 8
DATA: Final = 11

_SYMBOL_TABLE: Final = 8  # a subsection of the custom section "linking"
_FUNCTION: Final = 0  # kind of symbol and of export
_DATA: Final = 1
_SECTION: Final = 3
_UNDEFINED: Final = 0x10  # flags of symbols
_NAMED: Final = 0x40


class _Reader:
    def __init__(self, data: bytes) -> None:
        self.data = data
        self.at = 0

    def __bool__(self) -> bool:
        return self.at < len(self.data)

    def take(self, count: int) -> bytes:
        self.at += count
        return self.data[self.at - count : self.at]

    def number(self) -> int:
        """The next unsigned LEB128 number."""
        value = shift = 0
        while True:
            (byte,) = self.take(1)
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def text(self) -> str:
        """The next length-prefixed text."""
        return self.take(self.number()).decode()


def _number(value: int) -> bytes:
    """`value` as unsigned LEB128."""
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _sized(content: bytes) -> bytes:
    return _number(len(content)) + content


def sections(module: bytes) -> Iterator[tuple[int, bytes]]:
    """Each section's number and content. Raises ValueError if the bytes are not a module."""
    if not module.startswith(HEADER):
        raise ValueError(f"{module[:8]!r} is not how a WebAssembly module begins")
    reader = _Reader(module[len(HEADER) :])
    while reader:
        (number,) = reader.take(1)
        yield number, reader.take(reader.number())


def custom(module: bytes, name: str) -> bytes | None:
    """The content of the custom section with this name, or None."""
    for number, content in sections(module):
        reader = _Reader(content)
        if number == CUSTOM and reader.text() == name:
            return content[reader.at :]
    return None


def with_custom(module: bytes, name: str, content: bytes) -> bytes:
    return module + bytes([CUSTOM]) + _sized(_sized(name.encode()) + content)


def with_exports(object_file: bytes, names: tuple[str, ...]) -> bytes:
    """Turn LLVM's object file into a module that exports these functions.

    Custom sections, which linkers read, are dropped. Raises ValueError if a function is missing, or
    if the object has data, which a linker would have to place in memory.
    """
    functions = _functions(custom(object_file, "linking") or b"")
    lacking = [name for name in names if name not in functions]
    if lacking:
        raise ValueError(f"the object has no function {', '.join(lacking)}")
    rows = [_sized(n.encode()) + bytes([_FUNCTION]) + _number(functions[n]) for n in names]
    exports = bytes([EXPORT]) + _sized(_number(len(rows)) + b"".join(rows))
    out = bytearray(HEADER)
    for number, content in sections(object_file):
        if number == DATA:
            raise ValueError("the object has data, which nothing here gives a place in memory")
        if number >= START and exports:
            out += exports
            exports = b""
        if number != CUSTOM:
            out += bytes([number]) + _sized(content)
    return bytes(out)


def _functions(linking: bytes) -> dict[str, int]:
    """The number of each function that an object defines, from its custom section "linking"."""
    reader = _Reader(linking)
    reader.number()  # version
    while reader:
        kind, content = reader.number(), reader.take(reader.number())
        if kind == _SYMBOL_TABLE:
            return dict(_defined(_Reader(content)))
    return {}


def _defined(table: _Reader) -> Iterator[tuple[str, int]]:
    for _ in range(table.number()):
        kind, flags = table.number(), table.number()
        if kind == _DATA:
            table.text()
            if not flags & _UNDEFINED:
                table.number(), table.number(), table.number()
        elif kind == _SECTION:
            table.number()
        else:
            index = table.number()
            if not flags & _UNDEFINED or flags & _NAMED:
                name = table.text()
                if kind == _FUNCTION and not flags & _UNDEFINED:
                    yield name, index
