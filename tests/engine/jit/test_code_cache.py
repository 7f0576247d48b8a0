"""Compiled modules are cached for the next process, and read only if they can be trusted."""

from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
import wasmtime

from plinko.engine.jit import code_cache, machine_code, native

CODE = wasmtime.wat2wasm('(module (func (export "seven") (result i32) i32.const 7))')


@pytest.fixture
def engine() -> wasmtime.Engine:
    return wasmtime.Engine()


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "plinko"


def seven(engine: wasmtime.Engine) -> int:
    """Run the module, which should return 7."""
    store = wasmtime.Store(engine)
    exports: Any = wasmtime.Instance(store, code_cache.module(engine, bytes(CODE)), []).exports(
        store
    )
    found: int = exports["seven"](store)
    return found


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The codes that were compiled from now on."""
    codes: list[bytes] = []

    class Counted(wasmtime.Module):
        def __init__(self, engine: wasmtime.Engine, code: bytes) -> None:
            codes.append(code)
            super().__init__(engine, code)

    monkeypatch.setattr(wasmtime, "Module", Counted)
    return codes


def test_a_module_is_compiled_once(
    engine: wasmtime.Engine, compiled: list[bytes], folder: Path
) -> None:
    assert [seven(engine), seven(engine)] == [7, 7]
    assert len(compiled) == 1
    (kept,) = folder.iterdir()
    assert kept.stat().st_mode & 0o777 == 0o600
    assert folder.stat().st_mode & 0o777 == 0o700
    assert kept.name.endswith(f".wasmtime-{version('wasmtime')}")


@pytest.mark.parametrize("harm", ["damaged", "empty", "writable", "folder", "link"])
def test_a_file_that_cannot_be_trusted_is_not_run(
    harm: str, engine: wasmtime.Engine, compiled: list[bytes], folder: Path
) -> None:
    assert seven(engine) == 7
    (kept,) = folder.iterdir()
    if harm == "damaged":
        content = bytearray(kept.read_bytes())
        content[-1] ^= 1
        kept.write_bytes(content)
    elif harm == "empty":
        kept.write_bytes(b"")
    elif harm == "writable":
        kept.chmod(0o622)
    elif harm == "folder":
        folder.chmod(0o777)
    else:
        kept.rename(folder.parent / "elsewhere")
        kept.symlink_to(folder.parent / "elsewhere")
    assert seven(engine) == 7
    assert len(compiled) == 2


def test_where_nothing_can_be_kept_it_is_compiled(
    engine: wasmtime.Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    assert seven(engine) == 7


def test_old_files_go(engine: wasmtime.Engine, folder: Path) -> None:
    folder.mkdir(mode=0o700)
    for number in range(code_cache.MOST_FILES):
        (folder / f"{number}.wasmtime-1").write_bytes(b"")
    assert seven(engine) == 7
    assert len(list(folder.iterdir())) == code_cache.MOST_FILES


@pytest.mark.parametrize(("forbidden", "files"), [(True, 0), (False, 1)])
def test_a_process_that_computes_for_others_keeps_nothing(
    forbidden: bool, files: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "is_forbidden", lambda: forbidden)
    module = machine_code.modules.__wrapped__()["plinko.engine.exact.trace.trace_many"]
    module.take()
    assert len(list(folder.glob("*"))) == files
