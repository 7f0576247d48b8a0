"""Checks short texts from strangers, such as names, before a page, picture or list shows them.

Refused are characters that are invisible, change the direction of the text around them, or cover
the lines above: control and format characters (including bidirectional ones), spaces except single
plain ones inside, and piled-up marks (Unicode Technical Standard 39, 5.4). An invisible character
is accepted where an orthography or an emoji needs it: a joiner after a virama or between Arabic
letters (Unicode Standard Annex 31, 2.3), joiners and variation selectors in emoji (UTS 51), the
variant of an ideograph. static/js/solver/input/plain-text.js has the same rules.
"""

import re
import unicodedata
from typing import Final

_UNSEEN: Final = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0"
    "\U000e0100-\U000e01ef]"
)
"""Invisible characters whose category is letter or mark."""

# The blocks with emoji, of which each version of Unicode adds some.
_PICTURE: Final = (
    "[\xa9\xae\u203c\u2049\u2122\u2139\u2190-\u21ff\u2300-\u23ff\u24c2\u25a0-\u27bf\u2900-\u297f"
    "\u2b00-\u2bff\u3030\u303d\u3297\u3299\U0001f000-\U0001faff]"
)
_EMOJI: Final = f"{_PICTURE}[\ufe0e\ufe0f]?[\U0001f3fb-\U0001f3ff]?"
_FLAGS: Final = "|".join(  # of England, Scotland and Wales, spelled with tags
    "\U0001f3f4" + "".join(chr(0xE0000 + ord(letter)) for letter in part) + "\U000e007f"
    for part in ("gbeng", "gbsct", "gbwls")
)
_EMOJIS: Final = re.compile(f"{_FLAGS}|{_EMOJI}(?:\u200d{_EMOJI})*|[0-9#*]\ufe0f?\u20e3")

VIRAMAS: Final = (
    "\u094d\u09cd\u0a4d\u0acd\u0b4d\u0bcd\u0c4d\u0ccd\u0d3b\u0d3c\u0d4d\u0dca\u0e3a\u0eba\u0f84"
    "\u1039\u103a\u1714\u1715\u1734\u17d2\u1a60\u1b44\u1baa\u1bab\u1bf2\u1bf3\u2d7f\ua806\ua82c"
    "\ua8c4\ua953\ua9c0\uaaf6\uabed\U00011133\U00011134"
)
"""Marks that take a letter's vowel away or join letters (combining class 9) in living scripts."""

_ARABIC: Final = (  # letters and marks, not punctuation
    "\u0610-\u061a\u0620-\u065f\u066e-\u06d3\u06d5-\u06dc\u06df-\u06e8\u06ea-\u06ef\u06fa-\u06ff"
    "\u0710-\u074a\u0750-\u077f\u08a0-\u08e1\u08e3-\u08ff\ufb50-\ufdfb\ufe70-\ufefc"
)
_JOINERS: Final = re.compile(
    f"([{VIRAMAS}])[\u200c\u200d]"
    f"|([^ \u200c\u200d])\u200d(?=[{VIRAMAS}])"
    f"|([{_ARABIC}])\u200c(?=[{_ARABIC}])"
    "|([\u3400-\u4dbf\u4e00-\u9fff\uf900-\ufaff\U00020000-\U0003ffff])[\U000e0100-\U000e01ef]"
    "|([\u1820-\u1878\u1880-\u18aa])[\u180b-\u180f]"
)
"""Each with the character before it, which stays."""

_MARKS: Final = 4
"""Most marks on a letter: Burmese, Tibetan and pointed Hebrew need as many."""

_PILED: Final = re.compile("[\u0300-\u036f\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]{3}")
"""Marks of no script, as Latin letters have them; after NFC no orthography needs three."""


def normal(value: object) -> str:
    """`value` in Unicode's form NFC, or an empty text if it is not a string."""
    return unicodedata.normalize("NFC", value) if isinstance(value, str) else ""


def is_printable(text: str) -> bool:
    """Whether every character can be seen, or joins others where it should; spaces are plain."""
    return _without_joiners(text).isprintable()


def fault(text: str, most: int) -> str | None:
    """Return the first requirement that `text` violates, to continue 'it must be'; None if valid.

    text: from `normal`. most: largest number of characters.
    """
    if not 0 < len(text) <= most:
        return f"a text of 1 to {most} characters"
    seen = _without_joiners(text)
    if not seen.isprintable() or _UNSEEN.search(seen):
        return "plain text: letters, marks, figures, signs, spaces"
    if seen != " ".join(seen.split()):
        return "a text without spaces at its ends or two in a row"
    if _is_piled_up(seen):
        return f"a text with at most {_MARKS} marks on a letter, and none twice"
    return None


def _without_joiners(text: str) -> str:
    """The text without invisible characters where they belong; an emoji becomes one plain one."""
    return _JOINERS.sub(r"\1\2\3\4\5", _EMOJIS.sub("\u263a", text))


def _is_piled_up(text: str) -> bool:
    """Whether a mark has no letter, or a letter too many marks or one twice."""
    row = ""
    before = " "
    for character in text:
        category = unicodedata.category(character)
        if category.startswith("M") and before == " ":
            return True
        row = row + character if category in ("Mn", "Me") else ""
        if len(row) > _MARKS or row[-2:] == 2 * character:
            return True
        before = character
    return _PILED.search(text) is not None
