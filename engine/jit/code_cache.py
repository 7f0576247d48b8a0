"""A cache on disk of the modules that wasmtime has compiled; reading one takes a millisecond.

A cached file is code that will run. It is used only if the user owns it and its folder, no one else
may write to them, and its digest is right. Files are replaced atomically. If anything fails, such
as writing to the folder, the module is compiled instead.
"""

import os
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Final

import wasmtime

MOST_FILES: Final = 32
"""Files of all versions together, 0.05 to 0.3 MB each; the oldest are deleted."""

_DIGEST = 32  # bytes of SHA-256 in front of the compiled module


def folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "plinko")


def module(engine: wasmtime.Engine, code: bytes) -> wasmtime.Module:
    """The module of this code, from the cache or compiled."""
    # OSError: no file, or not trusted; RuntimeError: no home; WasmtimeError: another processor.
    with suppress(OSError, RuntimeError, wasmtime.WasmtimeError):
        return wasmtime.Module.deserialize(engine, _read(_file(code)))
    made = wasmtime.Module(engine, code)
    with suppress(OSError, RuntimeError):
        _keep(_file(code), bytes(made.serialize()))
    return made


def _file(code: bytes) -> Path:
    return folder() / f"{sha256(code).hexdigest()[:32]}.wasmtime-{version('wasmtime')}"


def _read(path: Path) -> bytes:
    """The module in a cached file. Raises OSError if the file is not to be trusted."""
    _check(path.parent.lstat(), stat.S_ISDIR)
    opened = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    with os.fdopen(opened, "rb") as file:
        _check(os.fstat(opened), stat.S_ISREG)
        content = file.read()
    if sha256(content[_DIGEST:]).digest() != content[:_DIGEST]:
        raise OSError(f"{path} is damaged")
    return content[_DIGEST:]


def _check(found: os.stat_result, is_kind: Callable[[int], bool]) -> None:
    """Raise OSError unless the user owns it, no one else may write to it, and its kind is right."""
    is_own = hasattr(os, "geteuid") and found.st_uid == os.geteuid()
    if not (is_kind(found.st_mode) and is_own and not found.st_mode & 0o022):
        raise OSError("others may write to it")


def _keep(path: Path, content: bytes) -> None:
    """Replace a file atomically, with mode 0600, and delete the oldest ones."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    _check(path.parent.lstat(), stat.S_ISDIR)
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=".")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(sha256(content).digest() + content)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    kept = sorted(path.parent.glob("*.wasmtime-*"), key=lambda each: each.stat().st_mtime)
    for old in kept[:-MOST_FILES]:
        old.unlink(missing_ok=True)
