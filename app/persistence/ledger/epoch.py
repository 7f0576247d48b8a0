"""The file beside the ledger that tells whether the ledger is the one that this server left.

Each start of a server draws a random name, its epoch, under which it writes: the epoch's row in the
table `writers` has the number of its last commit. The file beside the ledger has the same epoch and
the number of the last commit that may be acknowledged. A ledger that lacks this epoch, or is behind
this number, has lost commits: its write-ahead log was cut, a backup was restored, or it is a copy.

The order of the steps:

    start   the new epoch's row is committed; the file gets the new epoch, durably
    commit  COMMIT with the number n; the file gets n; callers receive the outcome

Nothing restored, nothing refused, wherever a process or a machine dies: a start deletes only the
row before that of the file's epoch, whose number is always at least the file's.

Restored, therefore refused: whatever was acknowledged has a commit number up to the file's, in the
file's epoch or before it. A ledger of an earlier state lacks that epoch, or has a lower number. An
epoch of which the file has no trace acknowledged nothing, because its start did not end.

A new epoch replaces the file. The number is overwritten in place, 87 bytes within one sector,
without waiting for the disk: that would double the time of a commit. So a power cut may set the
number back by the seconds that the system keeps writes in memory, never forward. Only a backup that
was made in these very seconds, and is restored right after the cut, is then taken for the present.
"""

import os
from pathlib import Path
from typing import Final, NamedTuple

from plinko.app.errors import LedgerError

_DIGITS: Final = 20


def sync_names(folder: Path) -> None:
    """Make the names of files in a folder durable, such as after a rename."""
    directory = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(directory)
    finally:
        os.close(directory)


class Place(NamedTuple):
    """A moment of a ledger: the id of its log of receipts, the epoch, the number of a commit."""

    log: str
    epoch: str
    commit: int

    def line(self) -> bytes:
        return f"{self.log} {self.epoch} {self.commit:0{_DIGITS}}\n".encode()


class EpochFile:
    """The file beside the ledger; for the ledger's thread."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._descriptor: int | None = None
        self._place: Place | None = None

    def read(self) -> Place | None:
        """What the file says; None if it is missing. Raises LedgerError if it is damaged."""
        try:
            text = self.path.read_bytes()
        except FileNotFoundError:
            return None
        parts = text.split()
        if len(parts) == len(Place._fields) and parts[-1].isdigit():
            place = Place(parts[0].decode("ascii", "replace"), parts[1].decode("ascii", "replace"),
                          int(parts[2]))  # fmt: skip
            if place.line() == text:
                return place
        raise LedgerError(
            f"{self.path} contains {text!r:.40} instead of an epoch; if it cannot be repaired, "
            "delete it and run `plinko ledger restore`"
        )

    def begin(self, place: Place) -> None:
        """Replace the file, which is durable on return."""
        self.close()
        self.path.parent.mkdir(0o700, parents=True, exist_ok=True)
        draft = self.path.with_name(f"{self.path.name}-new")
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC
        self._descriptor, self._place = os.open(draft, flags, 0o600), place
        os.pwrite(self._descriptor, place.line(), 0)
        os.fsync(self._descriptor)
        os.replace(draft, self.path)
        sync_names(self.path.parent)

    def note(self, commit: int) -> None:
        """Write the number of a commit, without waiting for the disk."""
        assert self._descriptor is not None
        assert self._place is not None
        os.pwrite(self._descriptor, self._place._replace(commit=commit).line(), 0)

    def close(self) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None
