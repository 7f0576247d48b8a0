"""Each request in docs/api.md is sent, and the response is the one that the page shows.

An ```http block has a request, and the ```json block after it the response. In a response, "…"
stands for any value, as the last item of a list for any further items, and as a key for any further
fields. "{name}" stores a text, which later requests use under the same name.
"""

import json
import re
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.kit.serving import serving

PAGE = Path(__file__).parents[2] / "docs" / "api.md"
_BLOCK = re.compile(
    r"```http\n(?P<request>.*?)```\n\n(?P<status>\d{3}).*?\n\n```json\n(?P<says>.*?)```", re.S
)
REST = "…"
OPERATOR = "an operator's token of enough characters"


def matches(says: Any, is_so: Any, kept: dict[str, str]) -> bool:
    """Whether a response matches the page; stores the texts that the page names in `kept`."""
    if says == REST:
        return True
    if isinstance(says, str) and (name := re.fullmatch(r"\{(\w+)\}", says)):
        kept[name[1]] = is_so
        return isinstance(is_so, str)
    if isinstance(says, dict) and isinstance(is_so, dict):
        fields = {name: value for name, value in says.items() if name != REST}
        known = fields.keys() == is_so.keys() or (REST in says and fields.keys() < is_so.keys())
        return known and all(matches(value, is_so[name], kept) for name, value in fields.items())
    if isinstance(says, list) and isinstance(is_so, list):
        if says and says[-1] == REST:
            says, is_so = says[:-1], is_so[: len(says) - 1]
        pairs = zip(says, is_so, strict=False)
        return len(says) == len(is_so) and all(matches(*pair, kept) for pair in pairs)
    return bool(says == is_so)


def filled(text: str, kept: dict[str, str]) -> str:
    return re.sub(r"\{(\w+)\}", lambda name: kept[name[1]], text)


def send(client: httpx.Client, request: str, kept: dict[str, str]) -> httpx.Response:
    head, _, body = request.partition("\n\n")
    first, *lines = head.splitlines()
    method, path, _version = filled(first, kept).split()
    headers = dict(filled(line, kept).split(": ", 1) for line in lines)
    if body:
        headers["content-type"] = "application/json"
    # In a body, a name in braces is a whole JSON string; all other braces belong to JSON.
    sent = re.sub(r'"\{(\w+)\}"', lambda name: json.dumps(kept[name[1]]), body)
    return client.request(method, path, content=sent.encode() or None, headers=headers)


def test_every_request_of_the_page_is_answered_as_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = list(_BLOCK.finditer(PAGE.read_text("utf-8")))
    assert len(blocks) == PAGE.read_text("utf-8").count("```http")
    kept = {"operator": OPERATOR}
    with (
        serving(operator_token=OPERATOR) as running,
        running.client() as client,
    ):
        for block in blocks:
            answer = send(client, block["request"], kept)
            assert answer.status_code == int(block["status"]), (block["request"], answer.text)
            says = json.loads(block["says"])
            assert matches(says, answer.json(), kept), (block["request"], answer.text)


def test_the_page_has_every_post() -> None:
    page = PAGE.read_text("utf-8")
    paths = re.findall(r"\bPOST (?:/api/v1/)?([\w{}/]+)", page)
    shown = {"/api/v1/" + re.sub(r"\{\w+\}", "{}", path) for path in paths}
    with serving() as running:
        document = httpx.get(f"{running.url}/openapi.json").json()
    posts = {
        re.sub(r"\{\w+\}", "{}", path)
        for path, operations in document["paths"].items()
        if "post" in operations
    }
    assert posts - shown == set()
