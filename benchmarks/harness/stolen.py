"""Stolen processor time: the host of a virtual machine gave it to others, so delays are not ours.

Linux reports it in /proc/stat.
"""

from pathlib import Path
from typing import Final

_STAT: Final = Path("/proc/stat")
_STEAL: Final = 7  # index of `steal` among a processor's times, see proc_stat(5)
_TIMES: Final = 8  # later columns (guest times) are included in earlier ones


class Stolen:
    """Measures from its construction on."""

    def __init__(self) -> None:
        self._begun = _times(_STAT.read_text())

    def share(self) -> float:
        """The stolen share of all processors' time since then, 0 to 1."""
        return share_between(self._begun, _times(_STAT.read_text()))


def share_between(before: list[int], after: list[int]) -> float:
    """The stolen share of the time between two readings; 0 if no time has passed."""
    spent = [new - old for old, new in zip(before, after, strict=True)]
    return spent[_STEAL] / sum(spent) if sum(spent) > 0 else 0.0


def _times(text: str) -> list[int]:
    """Sums over all processors: user, nice, system, idle, iowait, irq, softirq, steal."""
    return [int(each) for each in text.split("\n", 1)[0].split()[1 : 1 + _TIMES]]
