"""Conventions of REST: request ids, limits in headers, links between pages, 415, docs."""

import re
from pathlib import Path

import httpx
import pytest

from plinko.app.web.limits import TokenBucket
from tests.app.conftest import QUICK
from tests.app.test_errors import RESPONSES
from tests.kit.serving import serving
from tests.kit.waiting import LIMIT

ROOT = Path(__file__).parents[4]


def test_a_bucket_reports_its_rest_and_when_it_is_full() -> None:
    bucket = TokenBucket(rate=2.0, burst=10.0, now=0.0)
    for _ in range(4):
        assert bucket.take(0.0)
    assert bucket.allowance("drops", 0.5).policy == '"drops";q=10;w=5'
    assert bucket.allowance("drops", 0.5).rest == '"drops";r=7;t=2'
    bucket.charge(20.0)
    assert bucket.allowance("drops", 0.5).rest == '"drops";r=0;t=12'


def test_a_response_has_the_rest_of_the_limits_it_used() -> None:
    with serving(drop_rate=0.5) as running:
        at = f"{running.url}/api/v1/rooms/main/drops"
        answers = [httpx.post(at, timeout=LIMIT)]
        while answers[-1].status_code == 202:  # a slow machine sends few in two seconds
            answers.append(httpx.post(at, timeout=LIMIT))
        assert (answers[-1].status_code, answers[-1].json()["code"]) == (429, "rate-limited")
        assert int(answers[-1].headers["retry-after"]) >= 1
        assert {answer.headers["ratelimit-policy"] for answer in answers} == {'"drops";q=1;w=2'}
        rest = {'"drops";r=0;t=2', '"drops";r=0;t=1'}
        assert {answer.headers["ratelimit"] for answer in answers} <= rest
        computed = httpx.get(f"{running.url}/api/v1/drops/triangle-8/1", timeout=LIMIT)
        assert computed.headers["ratelimit-policy"] == '"computing-ms";q=30000;w=60'
        left = re.fullmatch(r'"computing-ms";r=(\d+);t=\d+', computed.headers["ratelimit"])
        assert left is not None
        assert 29_000 < int(left[1]) <= 30_000
        assert "ratelimit" not in httpx.get(f"{running.url}/healthz", timeout=LIMIT).headers


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "application/jsonish", "json", ""]
)
def test_a_body_that_says_it_is_no_json_is_refused(http: httpx.Client, kind: str) -> None:
    for path in ("drops", "boards", "rooms", "verify", "simulate", "payouts", "sessions"):
        refused = http.post(f"/api/v1/{path}", content="{}", headers={"content-type": kind})
        problem = refused.json()
        assert (refused.status_code, problem["code"]) == (415, "unsupported-media-type"), path
        assert problem["field"] == "content-type"
        assert repr(kind) in problem["detail"]


@pytest.mark.parametrize(
    "kind", ["application/json", "Application/JSON; charset=utf-8", "application/x.plinko+json"]
)
def test_json_by_any_of_its_names_is_read(http: httpx.Client, kind: str) -> None:
    body = '{"board":"triangle-8","seed":"1"}'
    for headers in ({"content-type": kind}, {}):
        found = http.post("/api/v1/drops", content=body, headers=headers)
        assert found.status_code == 200


def test_rooms_and_plays_and_logs_link_to_their_next_pages(http: httpx.Client) -> None:
    room = http.post("/api/v1/rooms", json={"board": QUICK}).json()["id"]
    for seed in range(3):
        drop = {"seed": str(seed), "who": "conventions-0123456789"}
        landed = http.post(f"/api/v1/rooms/{room}/drops?wait=1", json=drop)
        assert landed.status_code == 200
    for first in (
        "/api/v1/rooms?limit=1",
        f"/api/v1/rooms/{room}/log?limit=1",
        "/api/v1/players/conventions-0123456789/plays?limit=1",
    ):
        pages = [http.get(first)]
        while "next" in pages[-1].links:
            assert pages[-1].json()["next"] is not None
            pages.append(http.get(pages[-1].links["next"]["url"]))
        assert pages[-1].json()["next"] is None
        assert len(pages) >= (2 if "rooms?" in first else 3)


def test_the_table_of_errors_has_every_code_at_its_status() -> None:
    page = (ROOT / "docs" / "api.md").read_text("utf-8")
    rows = re.findall(r"^\| (\d{3}) \| (.+) \| .+ \|$", page, re.MULTILINE)
    table = {(status, code) for status, codes in rows for code in re.findall(r"`(.+?)`", codes)}
    socket_only = {"unknown-message", "no-such-ball", "too-many-messages", "room-full", "abuse"}
    socket_only |= {"too-slow", "client-gone"}
    missing = {
        response.code: response.status
        for response in RESPONSES.values()
        if response.code not in socket_only and (str(response.status), response.code) not in table
    }
    assert missing == {}


def test_the_docs_are_served_from_the_package(http: httpx.Client) -> None:
    page = http.get("/docs")
    assert page.headers["content-type"].startswith("text/html")
    assert "default-src 'none'" in page.headers["content-security-policy"]
    assert "<script>" not in page.text
    parts = re.findall(r'(?:src|href)="(/[^"]+)"', page.text)
    assert len(parts) == 3
    for part in parts:
        assert http.get(part).status_code == 200
    assert http.get("/docs/__init__.py").status_code == 404
