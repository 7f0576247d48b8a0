"""Parts of a film or picture: the header Range (RFC 9110, 14). Safari plays films only in parts."""

import re
from typing import Final

from fastapi import Request, Response

from plinko.app.errors import RangeError, shorten
from plinko.app.web.problems import problem_response

_RANGE: Final = re.compile(r"bytes\s*=\s*(\d*)-(\d*)", re.ASCII | re.IGNORECASE)
_DIGITS: Final = 18  # more than any size has


def in_part(request: Request, body: bytes, headers: dict[str, str], media_type: str) -> Response:
    """The whole body, or the part that the request asks for: 206, or 416 if it has no such part.

    `headers` include the ETag. The body is sent whole if several parts are asked for, if Range is
    malformed, or if the client has a part of another version (If-Range).
    """
    headers = {**headers, "accept-ranges": "bytes"}
    known = request.headers.get("if-range", headers["etag"])
    part = _part(request.headers.get("range", ""), len(body)) if known == headers["etag"] else None
    if part is None:
        return Response(body, headers=headers, media_type=media_type)
    if not part:
        error = RangeError(
            f"range {shorten(request.headers['range'], 60)}: there are {len(body)} bytes, 0 to "
            f"{len(body) - 1}",
            field="range",
        )
        response = problem_response(error, request.url.path)
        response.headers["content-range"] = f"bytes */{len(body)}"
        return response
    headers["content-range"] = f"bytes {part[0]}-{part[-1]}/{len(body)}"
    return Response(body[part.start : part.stop], 206, headers, media_type)


def _part(header: str, size: int) -> range | None:
    """The places of the bytes that the header names, of `size`; None if it names no single part."""
    match = _RANGE.fullmatch(header.strip())
    if match is None:
        return None
    begin, end = (int(text[:_DIGITS]) if text else None for text in match.groups())
    if begin is not None:
        if end is not None and end < begin:
            return None
        return range(begin, size if end is None else min(end + 1, size))
    return None if end is None else range(max(0, size - end), size)
