"""Writes the artifact, here and beside the page's module: python -m engine.artifact.make

Kernels are compiled in a process of its own, the plain way, by numba's public names, and nothing
that was compiled before is read: the same sources then give the same bytes.
"""

import gzip
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from engine.artifact import stamp

MOST_GZIPPED = 40_000
"""Bytes that a page may have to load for it."""

PAGE = Path(__file__).parents[2] / "static" / "js" / "solver" / "kernels.wasm"

_COMPILE = (
    "import sys; from engine.artifact.entries import EXPORTS; "
    "from engine.jit.webassembly import compile_module; "
    "sys.stdout.buffer.write(compile_module(EXPORTS))"
)


def made() -> bytes:
    """The artifact, made now."""
    with tempfile.TemporaryDirectory() as nothing:
        settings = {"NUMBA_CACHE_DIR": nothing, "NUMBA_OPT": "0", "PLINKO_PLAIN_NUMBA": "1"}
        done = subprocess.run(
            [sys.executable, "-W", "ignore:Cannot cache compiled function", "-c", _COMPILE],
            env={**os.environ, **settings},
            stdout=subprocess.PIPE,
            check=True,
        )
    return stamp.stamped(done.stdout)


def main() -> int:
    """Compile and write; 1 if it has become too large."""
    module = made()
    packed = len(gzip.compress(module))
    if packed > MOST_GZIPPED:
        print(f"{packed} bytes gzipped: more than {MOST_GZIPPED}")  # noqa: T201 - a command prints
        return 1
    for path in (stamp.FILE, PAGE):
        path.write_bytes(module)
    print(f"kernels.wasm: {len(module)} bytes, {packed} gzipped")  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
