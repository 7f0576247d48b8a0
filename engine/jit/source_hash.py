"""The stamp of an artifact: a hash of the sources that it was made from, to detect stale ones."""

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any, Final

from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.jit.wasm_sections import custom, with_custom

SECTION: Final = "plinko"
"""Name of the custom section with the stamp and other data about a module, as JSON."""

ENGINE: Final = Path(__file__).parents[1]


_MAKERS: Final = (
    ENGINE / "artifact" / "record_types.py",
    ENGINE / "jit" / "calls.py",
    ENGINE / "jit" / "kernel_compiler.py",
    ENGINE / "jit" / "llvm_module.py",
    ENGINE / "jit" / "webassembly.py",
    ENGINE / "jit" / "wasm_sections.py",
)
"""Sources that compile the kernels."""


def sources() -> list[Path]:
    """All Python files that the engine's machine code depends on."""
    found = [*_MAKERS, ENGINE / "constants.py", ENGINE / "certified" / "reach.py"]
    found += [ENGINE / "artifact" / name for name in ("libraries.py", "sample_calls.py")]
    found += [ENGINE / "jit" / "native_code.py"]
    for package in ("physics", "exact", "stepped", "multibody/solver"):
        found += (ENGINE / package).rglob("*.py")
    return sorted(found)


@cache
def current() -> dict[str, Any]:
    """The stamp that the engine's artifacts must have now."""
    return hash_of_files(sources())


def current_beside(file: Path) -> dict[str, Any]:
    """The stamp that the artifact of `file` must have now; its kernels may call the engine's."""
    return hash_of_files([file, *sources()])


def hash_of_files(files: list[Path]) -> dict[str, Any]:
    """The stamp of an artifact that is made from these files."""
    text = b"\0".join(path.read_bytes() for path in files)
    return {"physics_version": PHYSICS_VERSION, "sources": hashlib.sha256(text).hexdigest()}


def stamped(module: bytes, made_from: dict[str, Any], **said: Any) -> bytes:
    """The module with its stamp and the data `said`."""
    return with_custom(module, SECTION, json.dumps({**made_from, **said}).encode())


def read(module: bytes) -> dict[str, Any]:
    """The stamp and other data of an artifact. Raises ValueError if it has none."""
    content = custom(module, SECTION)
    if content is None:
        raise ValueError(
            f"the module has no section {SECTION!r}: it was not made by `make kernels`"
        )
    said: dict[str, Any] = json.loads(content)
    return said


def is_of(made_from: dict[str, Any], said: dict[str, Any]) -> bool:
    """Whether an artifact with the data `said` has this stamp."""
    return made_from.items() <= said.items()
