"""The pages' languages: reads their texts, chooses one for a client, and fills it into HTML.

Each language has one file js/texts/<language>.json, an object from keys to texts. HTML names a key
in braces: `{{word.drop}}`. In `{{keys.aim|<kbd>Shift</kbd>}}` the element replaces the `{}` in the
text.
"""

import html
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from plinko.app.web.edge.accepted import weights

ENGLISH = "en"  # the source of all translations, and the default

_QUOTED = re.compile(r'"([\w.-]+)"')
_PLACE = re.compile(r"\{\{([\w.-]+)\}\}")
_AROUND = re.compile(r"\{\{([\w.-]+)\|(.*?)\}\}", re.S)  # an element within a text

Texts = Mapping[str, str | Mapping[str, str]]
"""Texts by key; a text with a number is an object from plural categories to texts."""


def path_of(language: str) -> str:
    """The file of a language's texts, relative to static/."""
    return f"js/texts/{language}.json"


def languages_of(static: Path) -> dict[str, Texts]:
    """The texts of all languages in `static`, English first."""
    names = sorted(path.stem for path in static.glob("js/texts/??.json"))
    names.sort(key=lambda name: name != ENGLISH)
    return {name: json.loads((static / path_of(name)).read_text("utf-8")) for name in names}


def used_in(code: str) -> set[str]:
    """The keys that the code may use: every quoted string that has the form of a key."""
    return set(_QUOTED.findall(code))


def filled(page: str, texts: Texts) -> str:
    """A page's HTML with a language's texts. Raises ValueError for a key without a text."""

    def text(key: str) -> str:
        found = texts.get(key)
        if not isinstance(found, str):
            raise ValueError(f"the page uses the text {key!r}, which the language does not have")
        return html.escape(found)

    page = _PLACE.sub(lambda place: text(place[1]), page)
    return _AROUND.sub(lambda place: text(place[1]).replace("{}", place[2]), page)


def chosen(
    accepted: str,
    languages: Iterable[str],
    *,
    address: str | None = None,
    cookie: str | None = None,
) -> str:
    """The language for a visitor: the address's, the cookie's, or the best of the accepted ones.

    `accepted` is the header Accept-Language (RFC 9110, 12.5.4); de-AT finds de (RFC 4647, 3.4).
    """
    available = list(languages)
    known = weights(accepted)
    liked = sorted((tag for tag in known if known[tag] > 0.0), key=lambda tag: -known[tag])
    ranked = [address or "", cookie or "", *liked]
    found = (name for tag in ranked if (name := tag.partition("-")[0].lower()) in available)
    return next(found, ENGLISH)
