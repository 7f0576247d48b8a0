"""Connected components of a grid that segments cut: which places can be joined without a crossing.

A node is joined to each of its four neighbours unless a segment crosses the edge between them. So
two nodes are in one component only if a path that crosses no segment joins them. The reverse holds
if that path is a few grid spacings wide.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plinko.engine.board.checks.obstacles import Floats, Ints

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Components:
    """A labelled grid: increasing xs (nx,) and ys (ny,) in m, and each node's label (ny, nx)."""

    xs: Floats
    ys: Floats
    label: Ints


def connected_components(xs: Floats, ys: Floats, segments: Floats) -> Components:
    """Label the components into which `segments`, shape (k, 4), cut the grid `xs` by `ys`; m.

    First finds the runs of connected nodes in each row, then joins runs across rows (union-find).
    """
    across, down = _open_edges(xs, ys, segments)
    starts = np.ones((len(ys), len(xs)), dtype=np.bool_)
    starts[:, 1:] = ~across
    runs: Ints = (np.cumsum(starts.ravel(), dtype=np.intp) - 1).reshape(starts.shape)
    upper, lower = _joined_runs(runs, down)
    return Components(xs, ys, _merged_labels(int(runs[-1, -1]) + 1, upper, lower)[runs])


def _open_edges(xs: Floats, ys: Floats, segments: Floats) -> tuple[Bools, Bools]:
    """Which edges in a row, (ny, nx - 1), and in a column, (ny - 1, nx), no segment crosses.

    A segment may meet a node or end on a grid line. To put it on one definite side, each segment
    counts as shifted to the right by an infinitesimal, and down by the square of that.
    """
    across = np.ones((len(ys), len(xs) - 1), dtype=np.bool_)
    down = np.ones((len(ys) - 1, len(xs)), dtype=np.bool_)
    x1, y1, x2, y2 = segments.T

    which, row = _lines_crossed(ys, y1, y2)
    share = (ys[row] - y1[which]) / (y2 - y1)[which]
    at = x1[which] + share * (x2 - x1)[which]
    column = np.searchsorted(xs, at, side="right") - 1
    inside = (column >= 0) & (column < len(xs) - 1)
    across[row[inside], column[inside]] = False

    which, column = _lines_crossed(xs, x1, x2)
    share = (xs[column] - x1[which]) / (x2 - x1)[which]
    at = y1[which] + share * (y2 - y1)[which]
    falls = ((x2 > x1) == (y2 > y1))[which] & (y1 != y2)[which]  # a shift to the right raises it
    row = np.where(falls, np.searchsorted(ys, at), np.searchsorted(ys, at, side="right")) - 1
    inside = (row >= 0) & (row < len(ys) - 1)
    down[row[inside], column[inside]] = False
    return across, down


def _lines_crossed(lines: Floats, a: Floats, b: Floats) -> tuple[Ints, Ints]:
    """Pairs of a segment, which spans a to b, and a line that it crosses, as two index arrays."""
    first = np.searchsorted(lines, np.minimum(a, b), side="right")
    last = np.searchsorted(lines, np.maximum(a, b), side="right")
    counts = last - first
    which = np.repeat(np.arange(len(a)), counts)
    before = np.cumsum(counts) - counts
    return which, np.arange(len(which)) - np.repeat(before - first, counts)


def _joined_runs(runs: Ints, down: Bools) -> tuple[Ints, Ints]:
    """Pairs of runs, one in a row and one in the next, that an open edge joins."""
    upper, lower = runs[:-1][down], runs[1:][down]
    new = np.ones(len(upper), dtype=np.bool_)
    new[1:] = (upper[1:] != upper[:-1]) | (lower[1:] != lower[:-1])
    return upper[new], lower[new]


def _merged_labels(count: int, a: Ints, b: Ints) -> Ints:
    """Label of each of `count` runs, equal for those that the pairs `a`, `b` join (union-find)."""
    parent = list(range(count))
    for i, j in zip(a.tolist(), b.tolist(), strict=True):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]  # noqa: PLW2901 - walks up the tree
        while parent[j] != j:
            parent[j] = parent[parent[j]]
            j = parent[j]  # noqa: PLW2901 - walks up the tree
        if i != j:
            parent[max(i, j)] = min(i, j)
    label = np.empty(count, dtype=np.intp)
    for i, p in enumerate(parent):  # parents come before their children
        label[i] = i if p == i else label[p]
    return label
