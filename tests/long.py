"""How many cases tests try: a few in `make test`, many in `make test-long`.

The only switch is LONG=1 in the environment; `make test-long` sets it and runs all tests that are
marked `long`. `@pytest.mark.long` marks a test that tries a few cases without LONG=1, by `tries`.
`@pytest.mark.long("why")` marks a test that runs only with it: sieges, frozen processes,
measurements. tests/conftest.py marks the property tests.
"""

import os
from typing import Any, Final, TypeVar

import pytest

T = TypeVar("T")

LONG: Final = bool(os.environ.get("LONG"))


def tries(few: T, many: T) -> T:
    """`many` in `make test-long`, otherwise `few`: numbers, or lists of cases."""
    return many if LONG else few


def many(value: object) -> Any:
    """A case for `parametrize` that only `make test-long` tries: others show the same."""
    return pytest.param(value, marks=pytest.mark.long("one case of many"))
