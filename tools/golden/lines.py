"""The layout of golden files: one drop, board or message per line, so that diffs are short."""

import json
from typing import Any


def in_lines(document: dict[str, Any]) -> str:
    """The document as JSON, with a line for each member and for each item of a member."""
    return _spread(document, 2) + "\n"


def _spread(value: Any, depth: int) -> str:
    """The value with a line for each item, down to so many levels; below them on one line."""
    compact = json.dumps(value, allow_nan=False)
    if depth == 0 or not value or not isinstance(value, dict | list):
        return compact
    indent = " " * (3 - depth)
    if isinstance(value, dict):
        items = [f"{json.dumps(key)}: {_spread(item, depth - 1)}" for key, item in value.items()]
        opened, closed = "{}"
    else:
        items = [_spread(item, depth - 1) for item in value]
        opened, closed = "[]"
    inside = ",\n".join(indent + item for item in items)
    return f"{opened}\n{inside}\n{indent[1:]}{closed}"
