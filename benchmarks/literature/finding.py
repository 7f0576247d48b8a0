"""One published figure beside the engine's, with the error of both."""

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.harness.report import Table

COLUMNS = ("case", "published", "this engine", "off by", "source")


@dataclass(frozen=True)
class Estimate:
    """A mean of independent samples and its standard error."""

    value: float
    error: float

    @classmethod
    def of(cls, samples: npt.NDArray[np.float64]) -> "Estimate":
        """Of one sample for each ball; balls know nothing of each other."""
        return cls(float(samples.mean()), float(samples.std(ddof=1)) / sqrt(len(samples)))

    def off(self, wanted: float) -> float:
        """How many standard errors it is from `wanted`."""
        return abs(self.value - wanted) / self.error

    def __str__(self) -> str:
        """As 1.7605(7): the error in units of the last digit shown, one or two digits of it."""
        return with_error(self.value, self.error)


def with_error(value: float, error: float) -> str:
    """`value` to the first digit of `error`, which follows in brackets."""
    digits = max(0, -int(np.floor(np.log10(error)))) if error > 0.0 else 15
    return f"{value:.{digits}f}({round(error * 10**digits)})"


@dataclass(frozen=True)
class Finding:
    """A row: what it is about, both figures as text, how far they are apart, and who says so.

    `apart` is a difference, relative or in the figure's unit, as `off` says in words.
    """

    case: str
    published: str
    found: str
    off: str
    source: str
    apart: float

    def row(self) -> list[str]:
        """Its cells."""
        return [self.case, self.published, self.found, self.off, self.source]

    def to_dict(self) -> dict[str, Any]:
        """JSON form."""
        return {
            "case": self.case,
            "published": self.published,
            "found": self.found,
            "off": self.off,
            "source": self.source,
            "apart": self.apart,
        }


def statistical(case: str, wanted: float, digits: int, found: Estimate, source: str) -> Finding:
    """A figure that is a mean of many balls, against an exact one."""
    off = found.off(wanted)
    return Finding(case, f"{wanted:.{digits}f}", str(found), f"{off:.1f} σ", source, off)


def exact(case: str, wanted: float, found: float, source: str) -> Finding:
    """A figure that should be right to rounding; off by a relative difference."""
    apart = abs(found - wanted) / abs(wanted)
    return Finding(case, f"{wanted:.15g}", f"{found:.15g}", f"{apart:.0e}", source, apart)


def table(title: str, findings: list[Finding], notes: list[str]) -> Table:
    """The findings as a table."""
    return Table(title, COLUMNS, [finding.row() for finding in findings], notes)
