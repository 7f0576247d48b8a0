"""How notebooks show boards and drops: as an SVG figure with a caption, or as a PNG picture.

The engine itself writes the SVG text. Pictures need an installed package, whose entry point in the
group PICTURES names a function that takes the value; the server's package has one.
"""

from functools import cache
from html import escape
from importlib import import_module
from typing import Any, Final

PICTURES: Final = "plinko.pictures"
PNG: Final = "png"


def figure(svg: str, caption: str) -> str:
    """HTML of a drawing with a plain-text caption below it."""
    words = escape(caption, quote=False)
    return f'<figure style="margin:0">{svg}<figcaption><code>{words}</code></figcaption></figure>'


def png(value: object) -> bytes | None:
    """The PNG file of `value` from the installed painter; None without one."""
    painter = _painter()
    picture: bytes | None = None if painter is None else painter(value)
    return picture


@cache
def _painter() -> Any:
    # importlib.metadata is imported only for a picture, because it takes long to load.
    metadata = import_module("importlib.metadata")
    for entry in metadata.entry_points(group=PICTURES, name=PNG):
        return entry.load()
    return None
