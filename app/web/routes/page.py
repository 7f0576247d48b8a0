"""Serves the pages and files in static/, and answers paths that no other route serves."""

import asyncio
import functools
import hashlib
import html
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from threading import Lock
from urllib.parse import quote, urlencode

import brotli
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, RedirectResponse, Response
from starlette.routing import Match, Mount
from starlette.staticfiles import NotModifiedResponse, StaticFiles
from starlette.types import Scope

from plinko.app.web.edge.accepted import accepts_brotli, asks_for, whole
from plinko.app.web.edge.front import EMBEDDED
from plinko.app.web.page.languages import chosen, languages_of
from plinko.app.web.page.release import parts

PROOFS = find_spec("flint") is not None  # whether drops can be proven in this process
_READING = frozenset({"GET", "HEAD"})
_METHODS = ("GET", "POST", "PUT", "PATCH", "DELETE")

# Every file also has an address whose content never changes: v-<digest of all files>/<path>.
_ADDRESS = re.compile("v-([0-9a-f]{16})/(.+)")
_FOR_GOOD = "public, max-age=31536000, immutable"
_VIEWS = ("embed", "compare")  # options of a replay; other sites may show `embed` in a frame
_FORMER = {"embed/replay": "../replay.html?{}&embed", "compare.html": "replay.html?{}&compare"}
"""Addresses of version 1.0, and what they are now."""
_LANGUAGE = "language"
"""The cookie with the language that the visitor chose; without cookies it is in the address."""
_SCHEME = "scheme"  # the cookie with light or dark, so that the page begins in these colours
_SCHEMES = frozenset({"light", "dark"})
_KINDS = {".js": "text/javascript", ".css": "text/css"}
_PACKED = frozenset({".js", ".css", ".json", ".wasm", ".svg"})
_TABLE = "."  # the path of the live table, which has few forms; a replay has one for each drop
_KEPT = ("content-type", "etag", "vary")  # headers of a packed response
"""Files that are compressed once, with more effort than each response can have."""
_LOST = "404.html"
_OWN_LINKS = re.compile(r'(href|src)="(?:\./)?(?![a-z]+:|[/#])')
_OWN_PARTS = re.compile(r'(href|src)="((?:css|js)/|theme\.json)')


@dataclass(frozen=True, slots=True)
class Release:
    """The files as they are now, with the bundles made from them."""

    digest: str  # of every file's path and contents, 16 hex digits
    pages: dict[str, dict[str, str]]  # HTML by name and language, with one sheet and one script
    made: dict[str, str]  # the sheets and scripts, by paths at which there is no file

    def linked(self, page: str, language: str, to: str = "") -> str:
        """The page's HTML, with its parts at v-<release>/ below the folder `to`."""
        return _OWN_PARTS.sub(rf'\1="{to}v-{self.digest}/\2', self.pages[page][language])

    @classmethod
    def of(cls, directory: Path) -> "Release":
        pages: dict[str, dict[str, str]] = {}
        made: dict[str, str] = {}
        languages = languages_of(directory)
        for page in sorted(directory.glob("*.html")):
            text = page.read_text("utf-8")
            pages[page.name], its = parts(directory, page.name, text, languages)
            made |= its
        return cls(_digest_of(directory), pages, made)


class Page(StaticFiles):
    """Static files, with bundled pages (see release.py).

    A browser asks for a page each time, so that a new release shows at once. The page takes its
    sheet and script from v-<release>/, where files never change, so a browser loads them once.
    """

    def __init__(self, directory: Path, *, proofs: bool = PROOFS) -> None:
        """`proofs`: whether this server can prove drops; if not, pages hide the links to proofs."""
        super().__init__(directory=directory, html=True)
        self._proofs = proofs
        self._files = directory
        self._release: Release | None = None
        self._making = Lock()

    def prepare(self) -> "Release":
        """Bundle all pages, once. It takes 0.1 s, so it happens at the first request."""
        with self._making:
            if self._release is None:
                self._release = Release.of(self._files)
            return self._release

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        """The file; for a page its bundled HTML."""
        if not str(full_path).endswith(".html"):
            return super().file_response(full_path, stat_result, scope, status_code)
        return self._page(Path(full_path).name, scope, status_code)

    def _page(self, name: str, scope: Scope, status_code: int) -> Response:
        release = self.prepare()
        request = Request(scope)
        languages = release.pages[name]
        accepted = whole(request.headers, "accept-language")
        address, cookie = request.query_params.get(_LANGUAGE), request.cookies.get(_LANGUAGE)
        language = chosen(accepted, languages, address=address, cookie=cookie)
        text = release.linked(name, language)
        scheme = request.cookies.get(_SCHEME)
        if scheme in _SCHEMES:  # otherwise the sheet follows the system's scheme
            text = text.replace("<html ", f'<html data-scheme="{scheme}" ', 1)
        if not self._proofs:
            text = text.replace("<html ", '<html data-proofs="none" ', 1)
        view = next((each for each in _VIEWS if each in request.query_params), None)
        if name == "replay.html" and view:
            text = text.replace("<html ", f'<html data-view="{view}" ', 1)
        if name == _LOST:  # it is shown at any path, so its links must start at the root
            text = _OWN_LINKS.sub(rf'\1="{scope.get("root_path", "")}/', text)
        if name == "replay.html":
            about = card(request.query_params, str(request.base_url))
            text = text.replace("  </head>", f"{about}  </head>")
        response = self._made(text, scope, "text/html", status_code)
        response.headers.add_vary_header("accept-language, cookie")
        if name == "replay.html" and view == "embed":
            response.headers.update(EMBEDDED)
        return response

    def _made(self, text: str, scope: Scope, kind: str, status_code: int = 200) -> Response:
        """A response with a text that is not a file; 304 if the client has it already."""
        etag = hashlib.sha256(text.encode()).hexdigest()[:32]
        response = Response(text, status_code, {"etag": f'"{etag}"'}, kind)
        if self.is_not_modified(response.headers, Headers(scope=scope)):
            return NotModifiedResponse(response.headers)
        return response

    async def get_response(self, path: str, scope: Scope) -> Response:
        """The file, with a cache header; raises HTTPException 404, or 405 with allowed methods.

        This is the last of the application's routes. It sees every request that no other route
        matched, also one with the wrong method for another route: that must be 405, not 404.
        """
        if scope["method"] not in _READING:
            allowed = _methods_of_others(scope)
            if not allowed and self.lookup_path(path)[1] is not None:
                allowed = set(_READING)
            if not allowed:
                raise HTTPException(404)
            raise HTTPException(405, headers={"allow": ", ".join(sorted(allowed))})
        release = self._release
        if release is None:
            release = await asyncio.to_thread(self.prepare)
        of_release = _ADDRESS.fullmatch(path)
        path = of_release[2] if of_release else path
        if path in _FORMER:
            return RedirectResponse(_FORMER[path].format(scope["query_string"].decode("latin-1")))
        try:
            if path in release.made:
                response = self._made(release.made[path], scope, _KINDS[Path(path).suffix])
            else:
                response = await super().get_response(path, scope)
                if response.status_code == 404:
                    raise HTTPException(404)
        except HTTPException as error:
            allowed = _methods_of_others(scope) if error.status_code == 404 else set()
            if error.status_code == 404 and not allowed and _reads_pages(path, scope):
                lost = self._page(_LOST, scope, 404)
                lost.headers["cache-control"] = "no-cache"
                return lost
            if not allowed:
                raise
            raise HTTPException(405, headers={"allow": ", ".join(sorted(allowed))}) from error
        if response.status_code == 200 and (path == _TABLE or Path(path).suffix in _PACKED):
            response = await self._pack(path, scope, response)
        # During an upgrade a page may ask for another release's file. It gets this release's file,
        # which must not be cached under that address.
        for_good = of_release is not None and of_release[1] == release.digest
        response.headers.setdefault("cache-control", _FOR_GOOD if for_good else "no-cache")
        return response

    async def _pack(self, path: str, scope: Scope, plain: Response) -> Response:
        """The response in Brotli for a client that accepts it; the first one waits for it."""
        headers = Headers(scope=scope)
        if "range" in headers or not accepts_brotli(whole(headers, "accept-encoding")):
            return plain
        is_file = isinstance(plain, FileResponse)
        body = (self._files / path).read_bytes() if is_file else bytes(plain.body)
        kept = {name: plain.headers[name] for name in _KEPT if name in plain.headers}
        packed = await asyncio.to_thread(_brotli, body)
        response = Response(packed, 200, kept | {"content-encoding": "br"})
        response.headers.add_vary_header("accept-encoding")
        return response


@functools.lru_cache(maxsize=256)
def _brotli(body: bytes) -> bytes:
    packed: bytes = brotli.compress(body)
    return packed


def _reads_pages(path: str, scope: Scope) -> bool:
    """Whether the client is a browser; a program gets a problem document instead of a page."""
    return not path.startswith("api/") and asks_for(
        whole(Headers(scope=scope), "accept"), "text/html"
    )


def _digest_of(directory: Path) -> str:
    """A digest of every file's path and contents, 16 hex digits."""
    digest = hashlib.sha256()
    for path in sorted(path for path in directory.rglob("*") if path.is_file()):
        contents = path.read_bytes()
        digest.update(f"{path.relative_to(directory).as_posix()}\n{len(contents)}\n".encode())
        digest.update(contents)
    return digest.hexdigest()[:16]


def _methods_of_others(scope: Scope) -> set[str]:
    """The methods with which another route would match this path."""
    others = [route for route in scope["app"].routes if not isinstance(route, Mount)]
    allowed = {
        method
        for method in _METHODS
        if any(route.matches({**scope, "method": method})[0] is Match.FULL for route in others)
    }
    return allowed | {"HEAD"} if "GET" in allowed else allowed


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
