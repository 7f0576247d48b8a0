"""A row of the comparison: a published figure, the engine's figure, and their difference."""

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
        """The estimate from one sample per ball; balls are independent."""
        return cls(float(samples.mean()), float(samples.std(ddof=1)) / sqrt(len(samples)))

    def off(self, wanted: float) -> float:
        """Distance from `wanted` in standard errors."""
        return abs(self.value - wanted) / self.error

    def __str__(self) -> str:
        """Like 1.7605(7): in brackets the error, in units of the last digit shown."""
        return with_error(self.value, self.error)


def with_error(value: float, error: float) -> str:
    """`value` up to the first digit of `error`, with the error in brackets."""
    digits = max(0, -int(np.floor(np.log10(error)))) if error > 0.0 else 15
    return f"{value:.{digits}f}({round(error * 10**digits)})"


@dataclass(frozen=True)
class Finding:
    """A row: the case, both figures as text, their difference, and the source.

    `apart` is the difference as a number, which `off` shows as text: in standard errors, relative,
    or in the figure's unit.
    """

    case: str
    published: str
    found: str
    off: str
    source: str
    apart: float

    def row(self) -> list[str]:
        return [self.case, self.published, self.found, self.off, self.source]

    def to_dict(self) -> dict[str, Any]:
        return {
            "case": self.case,
            "published": self.published,
            "found": self.found,
            "off": self.off,
            "source": self.source,
            "apart": self.apart,
        }


def statistical(case: str, wanted: float, digits: int, found: Estimate, source: str) -> Finding:
    """Compare a mean over many balls with an exact figure; `apart` is in standard errors."""
    off = found.off(wanted)
    return Finding(case, f"{wanted:.{digits}f}", str(found), f"{off:.1f} σ", source, off)


def exact(case: str, wanted: float, found: float, source: str) -> Finding:
    """Compare a figure that should be right up to rounding; `apart` is a relative difference."""
    apart = abs(found - wanted) / abs(wanted)
    return Finding(case, f"{wanted:.15g}", f"{found:.15g}", f"{apart:.0e}", source, apart)


def table(title: str, findings: list[Finding], notes: list[str]) -> Table:
    return Table(title, COLUMNS, [finding.row() for finding in findings], notes)
