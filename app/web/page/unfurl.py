"""The preview that other sites show of a link to a drop: Open Graph title, text and picture.

Source: https://ogp.me. The drop is not looked up: if it does not exist, the picture is missing.
"""

import html
import re
from collections.abc import Mapping
from urllib.parse import quote, urlencode

_BOARD = re.compile("[a-z0-9-]{1,64}")  # a preset's name or a digest
_SEED = re.compile("[0-9]{1,20}")
_CHOICES = ("x", "aim", "solver", "dt", "substeps")  # the rest of a drop's address
_MOST = 32  # characters of one of these values
_WIDTH = 1200  # pixels, the width of a large card
_MOMENT = "1.5"  # s after the start; on most boards the ball is still falling


def card(query: Mapping[str, str], base: str) -> str:
    """`<meta>` elements for the replay of `query`; `base` is the site's address, with a final `/`.

    The title names the drop, but nothing says where it lands. There is no picture if the query has
    no valid seed and board. (A board in a link's fragment is never sent to the server.)
    """
    board, seed = query.get("board", ""), query.get("seed", "")
    about = {"og:type": "website", "og:site_name": "Plinko"}
    if not (_BOARD.fullmatch(board) and _SEED.fullmatch(seed)):
        about |= {"og:title": "A Plinko ball", "og:description": _INVITATION}
        return _elements(about)
    choices = {name: query[name] for name in _CHOICES if 0 < len(query.get(name, "")) <= _MOST}
    link = {"board": board, "seed": seed} | choices
    link |= {"guess": ""} if "guess" in query else {}
    picture = f"{base}api/v1/drops/{quote(board)}/{quote(seed)}.png?"
    about |= {
        "og:title": f"Seed {seed} on {board}",
        "og:description": _INVITATION,
        "og:url": f"{base}replay.html?{urlencode(link)}",
        "og:image": picture + urlencode(choices | {"t": _MOMENT, "width": str(_WIDTH)}),
        "og:image:type": "image/png",
        "og:image:alt": f"A ball on its way through the board {board}",
        "twitter:card": "summary_large_image",
    }
    return _elements(about)


_INVITATION = "One ball, one seed, exact physics. Guess the bin, then watch it fall."


def _elements(about: Mapping[str, str]) -> str:
    return "".join(
        f'    <meta property="{name}" content="{html.escape(content)}">\n'
        for name, content in about.items()
    )
