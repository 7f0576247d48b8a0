"""The languages of the pages: their texts, which of them a client reads, and HTML filled with them.

Texts are JSON by keys, js/texts/<language>.json, one file for a language. HTML names them in
braces: `{{word.drop}}`, or `{{keys.aim|<kbd>Shift</kbd>}}` where an element stands at the text's
`{}`.
"""

import html
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

ENGLISH = "en"  # what everything is written in first, and who reads none of the others gets

_QUOTED = re.compile(r'"([\w.-]+)"')
_PLACE = re.compile(r"\{\{([\w.-]+)\}\}")
_AROUND = re.compile(r"\{\{([\w.-]+)\|(.*?)\}\}", re.S)  # an element within a text

Texts = Mapping[
    str, str | Mapping[str, str]
]  # by keys; by plural categories where there are several


def path_of(language: str) -> str:
    """Where a language's texts lie below static/."""
    return f"js/texts/{language}.json"


def languages_of(static: Path) -> dict[str, Texts]:
    """The texts of all languages that are there, English first."""
    names = sorted(path.stem for path in static.glob("js/texts/??.json"))
    names.sort(key=lambda name: name != ENGLISH)
    return {name: json.loads((static / path_of(name)).read_text("utf-8")) for name in names}


def used_in(code: str) -> set[str]:
    """What may be keys of texts that the code uses: all in quotes that has their form."""
    return set(_QUOTED.findall(code))


def filled(page: str, texts: Texts) -> str:
    """A page's HTML with a language's texts. Raises ValueError for a key that has no text."""

    def text(key: str) -> str:
        found = texts.get(key)
        if not isinstance(found, str):
            raise ValueError(f"the page asks for the text {key!r}, which the language has not")
        return html.escape(found)

    page = _PLACE.sub(lambda place: text(place[1]), page)
    return _AROUND.sub(lambda place: text(place[1]).replace("{}", place[2]), page)


def chosen(cookie: str | None, accepted: str, languages: Iterable[str]) -> str:
    """The language of an answer: the one that a visitor chose, or else accepts before all others.

    `accepted` is the header Accept-Language (RFC 9110, 12.5.4); de-AT finds de (RFC 4647, 3.4).
    """
    there = list(languages)
    ranked = [cookie or "", *_by_weight(accepted)]
    found = (name for tag in ranked if (name := tag.partition("-")[0].lower()) in there)
    return next(found, ENGLISH)


def _by_weight(accepted: str) -> list[str]:
    """Languages of the header, the most wanted first; none that is unwanted."""
    tags: list[tuple[float, str]] = []
    for part in accepted.split(","):
        tag, _, weight = part.partition(";")
        value = weight.strip().removeprefix("q=")
        rank = float(value) if re.fullmatch(r"[01](?:\.\d{0,3})?", value) else 1.0
        if rank > 0:
            tags.append((rank, tag.strip()))
    return [tag for _, tag in sorted(tags, key=lambda tag: -tag[0])]
