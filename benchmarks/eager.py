"""`plinko` whose garbage is collected whenever Python likes: what app.garbage is measured against.

python -m benchmarks.eager serve …
"""

import gc
import sys

import app.main
from app import cli


class _LetAlone:
    """A watcher of the ticker that leaves the collector as it is."""

    def woke(self) -> None:
        """Nothing."""

    def ticked(self, late: float, duration: float) -> None:
        """Nothing."""

    def slept(self) -> None:
        """Nothing."""


def main() -> int:
    """Run the command line without what keeps garbage out of the way."""
    setattr(app.main, "GarbageKeeper", _LetAlone)  # noqa: B010 - it is no part of its interface
    setattr(gc, "freeze", lambda: None)  # noqa: B010 - as above
    return cli.main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
