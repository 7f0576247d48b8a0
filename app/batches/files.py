"""Write files whole or not at all: under another name beside their own, which they get at the end.

A reader never finds part of a file, whether the program is killed or the disk is full.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class Draft:
    """A new file at `path`, beside the file that it replaces when it is complete.

    A device or a pipe cannot be replaced: then `path` is the file itself.
    """

    def __init__(self, target: Path) -> None:
        self._target = Path(os.path.realpath(target))  # a link stays, and its file is replaced
        self._is_file = self._target.is_file() or not self._target.exists()
        unfinished = self._target.with_name(self._target.name + ".new")
        self.path = unfinished if self._is_file else self._target

    def commit(self) -> None:
        """Replace the file atomically."""
        if self._is_file:
            self.path.replace(self._target)

    def discard(self) -> None:
        """Remove the draft; without effect after `commit`."""
        if self._is_file:
            self.path.unlink(missing_ok=True)


def write_whole(target: Path, content: bytes) -> None:
    """Replace a file atomically; an OSError names it and leaves the file as it was."""
    draft = Draft(target)
    with naming(target):
        try:
            draft.path.write_bytes(content)
            draft.commit()
        finally:
            draft.discard()


@contextmanager
def naming(target: Path) -> Iterator[None]:
    """Have errors name `target`: an error of a full disk names no file, others name the draft."""
    try:
        yield
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise OSError(error.errno, reason, str(target)) from error
