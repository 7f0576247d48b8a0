"""Headers that say what a client accepts, by the rules and examples of RFC 9110."""

import brotli
import httpx
import pytest

from plinko.app.web.edge.accepted import accepts_brotli, accepts_gzip, asks_for, weights


@pytest.mark.parametrize(
    ("header", "found"),
    [
        ("", {}),
        (",, ,", {}),
        ("audio/*; q=0.2, audio/basic", {"audio/*": 0.2, "audio/basic": 1.0}),
        ("da, en-GB;q=0.8, en;Q=0.7", {"da": 1.0, "en-gb": 0.8, "en": 0.7}),
        ("GZIP ; q = 0.500", {"gzip": 0.5}),
        ('text/csv;a="x,y;q=0";q=0.25, b', {"text/csv": 0.25, "b": 1.0}),
        ('a;x="never ends, b;q=0', {"a": 1.0}),
        ("a;q=2, b;q=nan, c;q=0.1234, d;q=-1", dict.fromkeys("abcd", 1.0)),
        ("a;q=0, a;q=0.3", {"a": 0.3}),
    ],
)
def test_each_name_has_a_weight(header: str, found: dict[str, float]) -> None:
    assert weights(header) == found


GZIP = {
    "": False,
    "gzip": True,
    "GZip": True,
    "x-gzip": True,
    "*": True,
    "compress, gzip;q=0.5": True,
    "gzip;q=0": False,
    "gzip; q=0.000, *": False,
    "*;q=0": False,
    "notgzip": False,
    "gzipped, br": False,
    "gzip;q=0.5, identity": False,
    "identity;q=0.5, gzip;q=0.5": True,
}


def test_a_response_is_compressed_for_clients_that_accept_it(http: httpx.Client) -> None:
    for header, compressed in GZIP.items():
        assert accepts_gzip(header) == compressed, header
        answer = http.get("/api/v1/boards/classic", headers={"accept-encoding": header})
        assert answer.headers.get("content-encoding") == ("gzip" if compressed else None), header
        assert "accept-encoding" in answer.headers["vary"].lower()
    # A header in two lines is one.
    lines = [("accept-encoding", "br"), ("accept-encoding", "gzip")]
    answer = http.get("/api/v1/boards/classic", headers=lines)
    assert answer.headers["content-encoding"] == "gzip"


BROTLI = {
    "": False,
    "gzip": False,
    "*": False,
    "gzip, deflate, br, zstd": True,
    "BR": True,
    "br;q=0": False,
    "br;q=0.5, gzip": False,
    "br, identity": True,
    "br;q=0.5, identity": False,
    "brotli": False,
}


def test_a_page_s_file_is_in_brotli_for_clients_that_accept_it(http: httpx.Client) -> None:
    plain = http.get("/theme.json", headers={"accept-encoding": "identity"})
    for header, packed in BROTLI.items():
        assert accepts_brotli(header) == packed, header
        asked = {"accept-encoding": header}
        with http.stream("GET", "/theme.json", headers=asked) as answer:
            body = b"".join(answer.iter_raw())
        assert (answer.headers.get("content-encoding") == "br") == packed, header
        assert "accept-encoding" in answer.headers["vary"].lower()
        assert answer.headers["content-type"] == plain.headers["content-type"]
        if packed:
            assert brotli.decompress(body) == plain.content
            assert answer.headers["etag"] == f"W/{plain.headers['etag']}"
            known = {"if-none-match": answer.headers["etag"]}
            assert http.get("/theme.json", headers=known).status_code == 304
    # A part of a file is a part of the file itself.
    asked = {"accept-encoding": "br", "range": "bytes=0-9"}
    part = http.get("/theme.json", headers=asked)
    assert (part.status_code, part.content) == (206, plain.content[:10])


TABLES = {
    "": False,
    "*/*": False,
    "text/csv": True,
    "TEXT/CSV": True,
    "text/*": True,
    "text/csv; charset=utf-8": True,
    "text/csv, */*;q=0.1": True,
    "text/csv, */*": True,
    "text/csv;q=0": False,
    "text/csv;q=0, text/*": False,
    "text/csv;q=0.5, application/json": False,
    "text/csv, application/json;q=0.9": True,
    "text/csvx": False,
    'x/y; a="text/csv"': False,
}


def test_a_list_of_plays_is_a_table_for_clients_that_ask_for_it(http: httpx.Client) -> None:
    for header, table in TABLES.items():
        assert asks_for(header, "text/csv", "application/json") == table, header
        answer = http.get("/api/v1/players/somebody/plays", headers={"accept": header})
        kind = "text/csv" if table else "application/json"
        assert answer.headers["content-type"].partition(";")[0] == kind, header


@pytest.mark.parametrize(
    ("header", "page"),
    [
        ("text/html,application/xhtml+xml,*/*;q=0.8", True),
        ("Text/HTML", True),
        ("*/*", False),
        ("text/html;q=0, */*", False),
        ("nottext/html", False),
    ],
)
def test_a_page_says_that_nothing_is_there_to_those_who_read_pages(
    http: httpx.Client, header: str, page: bool
) -> None:
    answer = http.get("/nowhere", headers={"accept": header})
    assert answer.status_code == 404
    assert answer.headers["content-type"].startswith("text/html") == page
