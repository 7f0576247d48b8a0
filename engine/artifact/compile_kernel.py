"""Compiles a kernel by numba for the types that a play has: python -m … KERNEL PLAY FOLDER

What engine/jit/compilation.py runs beside a long computation; the code is left in the folder.
"""

import os
import sys
from contextlib import suppress
from pathlib import Path

from engine.artifact.plays import PLAYS
from engine.jit.compilation import kept, named


def main(kernel: str, play: str, folder: str) -> None:
    """Compile the kernel of this name by calling it, politely."""
    with suppress(AttributeError, OSError):  # not everywhere
        os.nice(10)
    found = named(kernel)
    found.machine_code = kept(found, Path(folder))
    PLAYS[play]()


if __name__ == "__main__":
    main(*sys.argv[1:])
