"""How often tests try a claim: a few times in `make test`, many times in `make test-long`.

LONG=1 in the environment is the one switch, and `make test-long` runs all tests that are marked
`long`: `@pytest.mark.long` is for a test that tries its claim a few times without it, by `tries`;
`@pytest.mark.long("why")` for one that runs only with it: sieges, frozen processes, measurements.
Property tests are marked by tests/conftest.py.
"""

import os
from typing import Final, TypeVar

T = TypeVar("T")

LONG: Final = bool(os.environ.get("LONG"))


def tries(few: T, many: T) -> T:
    """`many` in `make test-long`, else `few`: counts, or lists of cases."""
    return many if LONG else few
