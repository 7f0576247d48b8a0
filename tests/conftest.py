"""For all tests: a deterministic profile of property tests, and no files where a user has his.

`make test` tries every claim; those marked `long` are tried many more times by `make test-long`,
which sets LONG=1: see tests/long.py.
"""

import os

from hypothesis import settings

# Property tests try the same examples in every run, and a slow machine fails none of them.
# HYPOTHESIS_PROFILE=search looks for new examples, many more of them.
settings.register_profile("ci", derandomize=True, deadline=None, database=None, max_examples=50)
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# Servers that tests start keep nothing where a user's server keeps its own; those that are to come
# back are given a directory.
os.environ.setdefault("PLINKO_DATABASE_URL", "sqlite://")
