"""Make the committed oracle files: python -m tools.oracle.make [--drops N] [BOARD …]."""

import argparse
import sys
import time

from tools.oracle import golden
from tools.oracle.scenes import accuracy_boards


def main() -> None:
    """Compute and write the files of the named boards, or of all."""
    boards = accuracy_boards()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("boards", nargs="*", metavar="BOARD", help=", ".join(boards))
    parser.add_argument("--drops", type=int, default=40, help="drops per board (40)")
    given = parser.parse_args()
    unknown = set(given.boards) - set(boards)
    if unknown:
        parser.error(f"no such board: {', '.join(sorted(unknown))}; there are {', '.join(boards)}")
    for name in given.boards or boards:
        board, begun = boards[name], time.perf_counter()
        drops = [golden.compute(board, x) for x in golden.starts(board, given.drops)]
        path = golden.save(name, board, drops)
        seconds = time.perf_counter() - begun
        sys.stdout.write(f"{path.name}: {len(drops)} drops in {seconds:.0f} s\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
