"""The game as a folder of static files, which any web host serves: `plinko site` writes it.

The pages find there what a server would answer without computing: the replies of `GET boards` as
files. Everything else the pages do themselves.
"""

import json
import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
from rcssmin import cssmin
from rjsmin import jsmin

from plinko.app.web.page.languages import ENGLISH, path_of
from plinko.app.web.routes.boards import list_of, odds_of, view_of
from plinko.app.web.routes.page import Release, card
from plinko.engine import Board, preset_names
from plinko.engine.payouts.listing import listed

# Other pages need a server.
_NAMES = ("index", "sandbox", "replay", "editor", "today", "verify", "class")
_PAGES = tuple(f"{name}.html" for name in _NAMES)
_AT_TOP = ("favicon.svg", "icons/*", "manifest.json")
_TOP_LINKS = re.compile(r'(href|src)="(favicon\.svg|icons/|manifest\.json)')


def write_site(static: Path, into: Path) -> None:
    """Write the site into a folder, in place of an earlier site there."""
    with TemporaryDirectory() as temporary:
        files = Path(temporary, "static")
        shutil.copytree(static, files)
        for path in files.rglob("*.device.js"):  # see js/net/ask.js
            path.replace(path.with_name(path.name.replace(".device.", ".")))
        for language, changed in json.loads((files / "js/texts/device.json").read_text()).items():
            texts = json.loads((files / path_of(language)).read_text("utf-8"))
            _write(files / path_of(language), json.dumps(texts | changed).encode())
        _write_boards(files / "api/v1")
        release = Release.of(files)
        for former in releases_in(into):
            shutil.rmtree(former)
        parts = into / f"v-{release.digest}"
        for folder in ("js", "api"):
            shutil.copytree(files / folder, parts / folder)
    for name, text in release.made.items():
        _write(parts / name, text.encode())
    for pattern in _AT_TOP:
        for path in static.glob(pattern):
            _write(into / path.relative_to(static), path.read_bytes())
    worker = (static / "sw.js").read_text("utf-8")
    worker = worker.replace("const SITE = false", "const SITE = true")
    _write(into / "sw.js", worker.encode())
    for page in _PAGES:
        for language in release.pages[page]:
            folder = "" if language == ENGLISH else language
            _write(into / folder / page, _page(static, release, page, language).encode())


def releases_in(folder: Path) -> list[Path]:
    """The folders that tell a site from other files."""
    return list(folder.glob("v-" + 16 * "[0-9a-f]"))


def _write_boards(folder: Path) -> None:
    """The replies of `GET boards`, `GET boards/{board}` and `GET boards/{board}/odds`."""
    _write(folder / "boards.json", list_of(map(listed, preset_names())))
    for name in preset_names():
        board = Board.preset(name)
        _write(folder / f"boards/{name}.json", msgspec.json.encode(view_of(board)))
        _write(folder / f"boards/{name}/odds.json", msgspec.json.encode(odds_of(board)))


def _page(static: Path, release: Release, page: str, language: str) -> str:
    up = "" if language == ENGLISH else "../"
    text = _TOP_LINKS.sub(rf'\1="{up}\2', release.linked(page, language, up))
    names = " ".join(release.pages[page])
    marks = f'data-proofs="none" data-languages="{names}"'
    script = jsmin((static / "parts/site.js").read_text("utf-8"))
    style = cssmin((static / "parts/site.css").read_text("utf-8"))
    head = f"    <script>{script}</script>\n    <style>{style}</style>\n    <title>"
    text = text.replace("<html ", f"<html {marks} ", 1).replace("    <title>", head, 1)
    return text.replace("  </head>", f"{card({}, '')}  </head>") if page == "replay.html" else text


def _write(path: Path, contents: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(contents)
