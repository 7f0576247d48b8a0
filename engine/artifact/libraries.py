"""Writes the lanes as native libraries; called by make.py.

LLVM makes an object file for each kind of processor; zig's linker turns it into a library.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import Final

from plinko.engine.artifact import record_types
from plinko.engine.artifact.sample_calls import lanes
from plinko.engine.exact.lanes.trace import KERNELS
from plinko.engine.jit import native, source_hash
from plinko.engine.jit.native_code import NativeEntry, Processor, compile_object

MOST: Final = 150_000
"""Bytes of a library, at most."""

PROCESSORS: Final[Mapping[str, Processor]] = MappingProxyType(
    {
        "x86-64-v3": Processor("x86_64-unknown-linux-gnu", "x86-64-v3"),
        # Use vectors of eight numbers: the loops are long enough to profit from wide registers.
        "x86-64-v4": Processor("x86_64-unknown-linux-gnu", "x86-64-v4", "-prefer-256-bit"),
        "aarch64": Processor("aarch64-unknown-linux-gnu", "generic"),
    }
)
"""The name of each library and the processor that it is made for."""

_ZIG_TARGETS: Final = {
    "x86_64-unknown-linux-gnu": "x86_64-linux-gnu.2.17",
    "aarch64-unknown-linux-gnu": "aarch64-linux-gnu.2.17",
}


def made() -> dict[str, bytes]:
    """Compile the libraries and their index; the content of each file by its name.

    The index has what engine/jit/native.py checks before it loads a library: the stamp, the
    kernels' arguments, and each library's hash. Raises ValueError if a library is too large.
    """
    parts = record_types.recorded(lanes)
    kernels = {name: parts[name] for name in KERNELS}
    exports = {name: NativeEntry(p.kernel.function, p.takes) for name, p in kernels.items()}
    libraries = {name: _library(exports, each) for name, each in PROCESSORS.items()}
    index = {
        **source_hash.current(),
        "calls": {name: part.signature._asdict() for name, part in kernels.items()},
        "libraries": {name: sha256(code).hexdigest() for name, code in libraries.items()},
    }
    files = {native.INDEX.name: (json.dumps(index, indent=1) + "\n").encode()}
    return files | {f"{name}.so": code for name, code in libraries.items()}


def _library(exports: Mapping[str, NativeEntry], processor: Processor) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "kernels.o"), Path(folder, "kernels.so")
        given.write_bytes(compile_object(exports, processor))
        command = [sys.executable, "-m", "ziglang", "cc", "-target", _ZIG_TARGETS[processor.triple]]
        subprocess.run(
            [*command, "-shared", "-nostdlib", "-s", "-o", str(found), str(given)], check=True
        )
        library = found.read_bytes()
    if len(library) > MOST:
        raise ValueError(f"{processor}: {len(library)} bytes, of at most {MOST}")
    return library


def main() -> None:
    native.FOLDER.mkdir(exist_ok=True)
    for name, content in made().items():
        (native.FOLDER / name).write_bytes(content)
        print(f"{name}: {len(content)} bytes")  # noqa: T201 - a command prints


if __name__ == "__main__":
    main()
