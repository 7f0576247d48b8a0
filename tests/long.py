"""How often tests try a claim: a few times in `make test`, many times in `make test-long`.

LONG=1 in the environment is the one switch. A test that tries more with it is marked
`@pytest.mark.long`, and `make test-long` runs all that are. Its claim is the same without. Property
tests are marked by tests/conftest.py.
"""

import os
from typing import Final, TypeVar

T = TypeVar("T")

LONG: Final = bool(os.environ.get("LONG"))


def tries(few: T, many: T) -> T:
    """`many` in `make test-long`, else `few`: counts, or lists of cases."""
    return many if LONG else few
