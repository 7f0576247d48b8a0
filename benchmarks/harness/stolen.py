"""Processor time that a virtual machine's host gave to others: what is late then is not ours."""

from pathlib import Path
from typing import Final

_STAT: Final = Path("/proc/stat")
_STEAL: Final = 7  # its place among a processor's times, see proc_stat(5)
_TIMES: Final = 8  # those after it are counted in earlier ones already


class Stolen:
    """Counts from when it is made."""

    def __init__(self) -> None:
        self._begun = _times(_STAT.read_text())

    def share(self) -> float:
        """The part of all processors' time that was stolen since, 0 to 1."""
        return share_between(self._begun, _times(_STAT.read_text()))


def share_between(before: list[int], after: list[int]) -> float:
    """The stolen part of the times between two readings; 0 where no time has passed."""
    spent = [new - old for old, new in zip(before, after, strict=True)]
    return spent[_STEAL] / sum(spent) if sum(spent) > 0 else 0.0


def _times(text: str) -> list[int]:
    """Of all processors together: user, nice, system, idle, iowait, irq, softirq, steal."""
    return [int(each) for each in text.split("\n", 1)[0].split()[1 : 1 + _TIMES]]
