"""What a notebook shows of a value: a figure with its caption, and a picture where one is drawn.

The engine draws lines as SVG text, which needs nothing. Whole pictures are drawn by whoever is
installed for it: an entry point of the group PICTURES names a function that takes the value.
"""

from functools import cache
from html import escape
from importlib import import_module
from typing import Any, Final

PICTURES: Final = "plinko.pictures"
PNG: Final = "png"


def figure(svg: str, caption: str) -> str:
    """HTML of a drawing above the plain text that says what it is."""
    words = escape(caption, quote=False)
    return f'<figure style="margin:0">{svg}<figcaption><code>{words}</code></figcaption></figure>'


def png(value: object) -> bytes | None:
    """PNG file of `value` by the installed painter; None where none is installed."""
    painter = _painter()
    picture: bytes | None = None if painter is None else painter(value)
    return picture


@cache
def _painter() -> Any:
    # Imported when a picture is wanted: it takes longer to load than all of this package's values.
    metadata = import_module("importlib.metadata")
    for entry in metadata.entry_points(group=PICTURES, name=PNG):
        return entry.load()
    return None
